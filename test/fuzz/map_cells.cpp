// SPDX-License-Identifier: BSD-3-Clause
// A sound map some of whose cells have been replaced by other values, against the CHECKs of their tables.
#include "images/depth_blob.h"
#include "small_map.h"

#include <sqlite3.h>

#include <fuzzer/FuzzedDataProvider.h>
#include <string>
#include <vector>

namespace facetloc::fuzz {
namespace {

/** Statements that set a column, each of any table, to ?1 in row number ?2. */
std::vector<std::string> updatesOf(sqlite3* db) {
  constexpr const char* kUpdates = R"sql(
    SELECT 'UPDATE ' || t.name || ' SET ' || c.name || ' = ?1 WHERE (' || t.keys || ') = ' ||
           '(SELECT ' || t.keys || ' FROM ' || t.name || ' LIMIT 1 OFFSET ?2)'
    FROM (SELECT name, (SELECT group_concat(k.name) FROM pragma_table_info(m.name) AS k WHERE k.pk > 0) AS keys
          FROM sqlite_master AS m WHERE type = 'table') AS t,
         pragma_table_info(t.name) AS c)sql";
  std::vector<std::string> updates;
  const auto add = [](void* list, int, char** cells, char**) {
    static_cast<std::vector<std::string>*>(list)->push_back(cells[0]);
    return 0;
  };
  require(sqlite3_exec(db, kUpdates, add, &updates, nullptr) == SQLITE_OK, sqlite3_errmsg(db));
  return updates;
}

/** A picture that unpacks: some values over and over, as many as a picture of the map has, or another number.
 */
std::vector<std::uint8_t> packedPicture(FuzzedDataProvider& input) {
  static const DepthPicture example = smallMap().view(0)->depth;
  constexpr std::size_t kMost = 4096;
  const std::size_t size = input.ConsumeBool() ? example.inverse_depth.size()
                                               : input.ConsumeIntegralInRange<std::size_t>(0, kMost);
  const auto some = input.ConsumeBytes<std::uint8_t>(input.ConsumeIntegralInRange<std::size_t>(2, 64));
  std::vector<std::uint16_t> values(size);
  for (std::size_t i = 0; i < size && !some.empty(); ++i)
    values[i] = static_cast<std::uint16_t>(some[i % some.size()] << 8 | some[(i + 1) % some.size()]);
  return depth_blob::encode(values, example.camera.width);
}

void bindValue(sqlite3_stmt* statement, FuzzedDataProvider& input) {
  const auto bindBlob = [statement](const std::vector<std::uint8_t>& blob) {
    const void* data = blob.empty() ? static_cast<const void*>("") : blob.data();
    sqlite3_bind_blob(statement, 1, data, static_cast<int>(blob.size()), SQLITE_TRANSIENT);
  };
  const auto some = [&input] { return input.ConsumeIntegralInRange<std::size_t>(0, 300); };
  switch (input.ConsumeIntegralInRange(0, 7)) {
  case 0:
    sqlite3_bind_null(statement, 1);
    break;
  case 1:
    sqlite3_bind_int64(statement, 1, input.ConsumeIntegral<std::int64_t>());
    break;
  case 2:
    sqlite3_bind_int(statement, 1, input.ConsumeIntegralInRange(-2, 100));
    break;
  case 3:
    sqlite3_bind_double(statement, 1, input.ConsumeFloatingPoint<double>());
    break;
  case 4:
    sqlite3_bind_double(statement, 1, input.ConsumeFloatingPointInRange(-2.0, 2.0));
    break;
  case 5: {
    const std::string text = input.ConsumeBytesAsString(some());
    sqlite3_bind_text(statement, 1, text.data(), static_cast<int>(text.size()), SQLITE_TRANSIENT);
    break;
  }
  case 6:
    bindBlob(input.ConsumeBytes<std::uint8_t>(some()));
    break;
  default:
    bindBlob(packedPicture(input));
  }
}

/** A value that SQLite refuses, such as a text among numbers, leaves the cell as it was. */
void replaceCell(sqlite3* db, FuzzedDataProvider& input) {
  static const std::vector<std::string> updates = updatesOf(db);
  const std::string& sql = updates[input.ConsumeIntegralInRange<std::size_t>(0, updates.size() - 1)];
  sqlite3_stmt* statement = nullptr;
  require(sqlite3_prepare_v2(db, sql.c_str(), -1, &statement, nullptr) == SQLITE_OK, sqlite3_errmsg(db));
  constexpr int kMostRows = 20;
  sqlite3_bind_int(statement, 2, input.ConsumeIntegralInRange(0, kMostRows));
  bindValue(statement, input);
  sqlite3_step(statement);
  sqlite3_finalize(statement);
}

}  // namespace
}  // namespace facetloc::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc::fuzz;
  static const std::string sound = smallMapFile();
  static const Folder folder;
  folder.clear();
  const auto path = folder.put("room.flmap", sound);
  FuzzedDataProvider input(data, size);
  sqlite3* db = nullptr;
  require(sqlite3_open(path.c_str(), &db) == SQLITE_OK, "the map cannot be opened");
  sqlite3_exec(db,
               "PRAGMA ignore_check_constraints = ON; PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF",
               nullptr, nullptr, nullptr);
  constexpr int kMostCells = 8;
  for (int i = 0; i < kMostCells && input.remaining_bytes() > 0; ++i) replaceCell(db, input);
  sqlite3_close(db);
  useMap(path);
  return 0;
}
