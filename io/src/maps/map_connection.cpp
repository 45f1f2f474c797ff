// SPDX-License-Identifier: BSD-3-Clause
#include "bytes/files.h"
#include "maps/map_reader.h"
#include "maps/map_schema.h"

#include <facetloc/io/map_database.h>

#include <algorithm>
#include <fmt/format.h>
#include <string>
#include <vector>

namespace facetloc::map_connection {

using namespace sqlite;

namespace {

int pragma(Connection& db, const std::string& name) {
  Statement statement(db, "PRAGMA " + name);
  return statement.step() ? statement.integer() : 0;
}

/** The formats of unreleased versions have numbers below these. */
constexpr int kMajorUnit = 1 << 16;
constexpr int kVersion = kMajorUnit * MapDatabase::kMajor + MapDatabase::kMinor;

std::string versionText(int version) {
  return fmt::format("{}.{}", version / kMajorUnit, version % kMajorUnit);
}

/** Throws unless the file is a map of a format that we understand. Newer minor formats only add columns and
 * tables. */
void requireMap(Connection& db) {
  int id = 0;
  try {
    id = pragma(db, "application_id");
  } catch (const IoError&) {
    if ((db.lastCode() & 0xFF) == SQLITE_NOTADB)
      throw IoError(db.name(), "is not a map: it is no SQLite database");
    throw;
  }
  if (id != MapDatabase::kApplicationId)
    throw IoError(db.name(), "is not a map: it is an SQLite database of another application, or empty");
  const int version = pragma(db, "user_version");
  if (version < kVersion)
    throw IoError(db.name(), "was written by an unreleased version of facetloc: build the map again");
  if (version / kMajorUnit > MapDatabase::kMajor)
    throw IoError(db.name(), fmt::format("map format {} is newer than this program understands ({}.x)",
                                         versionText(version), MapDatabase::kMajor));
}

/** A map consists of tables. A view, a trigger or a generated column in their place would compute anything
 * that the author of the file wants, whenever it is read: no map has any. */
void requireRealTables(Connection& db) {
  std::vector<std::string> tables;
  Statement entry(db, "SELECT type, name, coalesce(sql, '') AS sql FROM sqlite_master");
  sqlite::naming(db.name(), "is not sound: ", [&] {
    while (entry.step()) {
      const std::string type = entry.text(), name = entry.text(), sql = entry.text();
      if (type != "table" && type != "index") throw BadCell(fmt::format("it holds a {}, {}", type, name));
      if (type == "table" && sql.rfind("CREATE TABLE", 0) != 0 && name.rfind("sqlite_", 0) != 0)
        throw BadCell(fmt::format("its table {} is virtual", name));
      if (type == "table") tables.push_back(name);
    }
    Statement column(db, "SELECT t.name, x.name FROM sqlite_master AS t, pragma_table_xinfo(t.name) AS x "
                         "WHERE t.type = 'table' AND x.hidden > 0");
    if (column.step()) {
      const std::string table = column.text();
      throw BadCell(fmt::format("column {} of its table {} is computed", column.text(), table));
    }
    for (const char* needed : schema::kTableNames)
      if (std::find(tables.begin(), tables.end(), needed) == tables.end())
        throw BadCell(std::string("it has no table ") + needed);
  });
}

void configureForWriting(Connection& db) {
  db.execute("PRAGMA journal_mode = DELETE; PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON");
}

/** SQLite notices missing pages, but not a missing part of the last one. */
void requireWhole(Connection& db, const fs::path& path) {
  const int page_size = pragma(db, "page_size");
  if (page_size <= 0 || fs::file_size(path) % static_cast<std::uintmax_t>(page_size) != 0)
    throw IoError(path.string(), "is truncated");
}

void requireSound(Connection& db, const fs::path& path) {
  requireMap(db);
  requireWhole(db, path);
  requireRealTables(db);
}

Connection connect(const fs::path& path, int flags) {
  Connection db(path, flags);
  requireSound(db, path);
  return db;
}

}  // namespace

Connection openForWriting(const fs::path& path) {
  files::requireRegularFile(path);
  Connection db = connect(path, SQLITE_OPEN_READWRITE);
  configureForWriting(db);
  return db;
}

Connection openForReading(const fs::path& path) {
  files::requireRegularFile(path);
  constexpr int kAttempts = 20;  // SQLite takes a commit that just ends for one whose writer was killed
  for (int attempt = 1; attempt < kAttempts; ++attempt) {
    Connection db(path, SQLITE_OPEN_READONLY);
    try {
      requireSound(db, path);
      return db;
    } catch (const IoError&) {
      if (db.lastCode() != SQLITE_READONLY_ROLLBACK) throw;
    }
    connect(path, SQLITE_OPEN_READWRITE);
  }
  return connect(path, SQLITE_OPEN_READONLY);
}

fs::path journalOf(const fs::path& path) { return path.string() + "-journal"; }

void removeWithJournal(const fs::path& path) {
  std::error_code error;
  fs::remove(journalOf(path), error);
  if (!error) fs::remove(path, error);
  if (error) throw IoError(path.string(), "cannot be replaced: " + error.message());
}

Connection create(const fs::path& path, const fs::path& shown) {
  Connection db(path, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, shown);
  configureForWriting(db);
  Transaction transaction(db);
  db.execute(fmt::format("PRAGMA application_id = {}", MapDatabase::kApplicationId));
  db.execute(fmt::format("PRAGMA user_version = {}", kVersion));
  db.execute(schema::kTables);
  Statement meta(db, schema::insert("key, value", "meta"));
  (meta << kFormatKey << "facetloc map " + versionText(kVersion)).run();
  (meta << kConventionsKey << schema::kConventions).run();
  transaction.commit();
  return db;
}

}  // namespace facetloc::map_connection
