// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "temporary_folder.h"

#include <facetloc/io/depth_sequence.h>

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <filesystem>
#include <string>

namespace facetloc::test {

/** \brief Changes a recording that is a database. \return the error of reading all its images; empty if they
 * are read. */
inline std::string errorWhenChanged(const std::filesystem::path& recording, const char* sql) {
  sqlite3* db = nullptr;
  EXPECT_EQ(sqlite3_open(recording.c_str(), &db), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(db, sql, nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(db);
  sqlite3_close(db);
  return ioErrorOf([&] {
    const DepthSequence read = DepthSequence::open(recording);
    for (std::size_t i = 0; i < read.frames().size(); ++i) read.load(i);
  });
}

}  // namespace facetloc::test
