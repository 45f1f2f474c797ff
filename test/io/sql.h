// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <filesystem>
#include <string>

namespace facetloc::test {

/** \brief Changes a database as another program might. */
inline void sql(const std::filesystem::path& path, const std::string& statement) {
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &db), SQLITE_OK);
  char* message = nullptr;
  sqlite3_exec(db, statement.c_str(), nullptr, nullptr, &message);
  EXPECT_STREQ(message, nullptr) << statement;
  sqlite3_free(message);
  sqlite3_close(db);
}

/** \brief The same against the CHECKs of the tables. */
inline void vandalize(const std::filesystem::path& path, const std::string& statement) {
  sql(path, "PRAGMA ignore_check_constraints = ON; PRAGMA foreign_keys = OFF; " + statement);
}

}  // namespace facetloc::test
