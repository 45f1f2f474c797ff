// SPDX-License-Identifier: BSD-3-Clause
// The example program makes the same map as the tool.
#define main buildMapExample
#include "../../apps/examples/build_map.cpp"
#undef main

#include "example_room.h"

#include <sqlite3.h>

#include <algorithm>

namespace facetloc::test {
namespace {

/** The rows of a query, values as SQL writes them. */
std::vector<std::string> rowsOf(const std::string& map, const std::string& query) {
  sqlite3* db = nullptr;
  sqlite3_stmt* statement = nullptr;
  EXPECT_EQ(sqlite3_open_v2(map.c_str(), &db, SQLITE_OPEN_READONLY, nullptr), SQLITE_OK);
  EXPECT_EQ(sqlite3_prepare_v2(db, query.c_str(), -1, &statement, nullptr), SQLITE_OK) << query;
  std::vector<std::string> rows;
  while (sqlite3_step(statement) == SQLITE_ROW) {
    std::string row;
    for (int i = 0; i < sqlite3_column_count(statement); ++i) {
      const auto* bytes = static_cast<const char*>(sqlite3_column_blob(statement, i));
      const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement, i));
      row += bytes ? std::string(bytes, size) : "NULL";
      row += '\t';
    }
    rows.push_back(row);
  }
  sqlite3_finalize(statement);
  sqlite3_close(db);
  return rows;
}

std::vector<std::string> tablesOf(const std::string& map) {
  std::vector<std::string> names = rowsOf(map, "SELECT name FROM sqlite_master WHERE type = 'table'");
  for (std::string& name : names) name.pop_back();
  names.erase(std::remove(names.begin(), names.end(), "meta"), names.end());
  return names;
}

/** All columns but the scores that expectSameAmbiguity() compares. */
std::string columnsOf(const std::string& map, const std::string& table) {
  std::string columns;
  for (std::string name :
       rowsOf(map, "SELECT name FROM pragma_table_info('" + table + "') WHERE name <> 'lookalike_score'")) {
    name.pop_back();
    columns += (columns.empty() ? "\"" : ", \"") + name + "\"";
  }
  return columns;
}

void expectSameRows(const std::string& a, const std::string& b) {
  ASSERT_EQ(tablesOf(a), tablesOf(b));
  for (const std::string& table : tablesOf(a)) {
    if (table == "ambiguity") continue;
    const std::string query = "SELECT " + columnsOf(a, table) + " FROM \"" + table + "\"";
    EXPECT_TRUE(rowsOf(a, query) == rowsOf(b, query)) << table;
  }
}

/** The tool measures the ambiguity of the map in the file, whose rotations are rounded to quaternions. */
void expectSameAmbiguity(const Map& a, const Map& b) {
  constexpr double kRounding = 1e-6;  // [nats]
  ASSERT_TRUE(a.ambiguity && b.ambiguity);
  EXPECT_EQ(a.ambiguity->views, b.ambiguity->views);
  EXPECT_NEAR(a.ambiguity->score, b.ambiguity->score, kRounding);
  ASSERT_EQ(a.models.size(), b.models.size());
  for (std::size_t i = 0; i < a.models.size(); ++i) {
    const auto &of_a = a.models[i].alias_score, &of_b = b.models[i].alias_score;
    ASSERT_EQ(of_a.has_value(), of_b.has_value()) << i;
    EXPECT_NEAR(of_a.value_or(0), of_b.value_or(0), kRounding) << i;
  }
}

int buildAsTheExampleDoes(std::string recording, std::string map) {
  std::string name = "build_map";
  char* arguments[] = {name.data(), recording.data(), map.data(), nullptr};
  return buildMapExample(3, arguments);
}

/** A robot's recording of a room, by a bad camera whose mounting camera.ini conceals. */
class BuildMapExample : public testing::Test {
protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TemporaryFolder>();
    ok(runTool<simulateApp>({"room", "-o", *folder_ / "", "--seed", "8", "--map-frames", "60",
                             "--query-frames", "2", "--width", "320", "--drive.turn_deg", "8",
                             "--sensor.distortion", "1"}));
    std::string kept;
    for (const std::string& line : linesIn(contentOf(recording() + "/camera.ini")))
      if (line.rfind("mount_", 0) != 0) kept += line + "\n";
    writeContent(recording() + "/camera.ini", kept);
  }
  static void TearDownTestSuite() { folder_.reset(); }
  static std::string recording() { return *folder_ / "map"; }

  static std::unique_ptr<TemporaryFolder> folder_;
};
std::unique_ptr<TemporaryFolder> BuildMapExample::folder_;

TEST_F(BuildMapExample, MakesTheMapOfTheTool) {
  const std::string by_tool = *folder_ / "tool.flmap", by_example = *folder_ / "example.flmap";
  ok(runMap({"build", recording(), "-o", by_tool}));
  ASSERT_EQ(buildAsTheExampleDoes(recording(), by_example), 0);
  expectSameRows(by_tool, by_example);
  expectSameAmbiguity(readMap(by_tool), readMap(by_example));

  const Map map = readMap(by_example);
  EXPECT_THAT(checkMap(by_example), IsEmpty());
  EXPECT_GE(map.models.size(), 10u);
  EXPECT_EQ(map.links.size(), map.models.size() - 1);
  EXPECT_TRUE(map.camera.distortion);
  EXPECT_TRUE(map.camera.mounting);
  EXPECT_TRUE(map.ambiguity);
}

TEST_F(BuildMapExample, MakesTheMapOfTheToolWithoutPoses) {
  const std::string by_tool = *folder_ / "found.flmap", by_example = *folder_ / "found_too.flmap";
  fs::copy(recording(), *folder_ / "poseless", fs::copy_options::recursive);
  fs::remove(*folder_ / "poseless/groundtruth.txt");
  ASSERT_EQ(runMap({"build", recording(), "-o", by_tool, "--without-poses"}).code, 0);
  ASSERT_EQ(buildAsTheExampleDoes(*folder_ / "poseless", by_example), 0);
  expectSameRows(by_tool, by_example);
  expectSameAmbiguity(readMap(by_tool), readMap(by_example));
  EXPECT_GE(readMap(by_example).links.size(), readMap(by_example).models.size() - 1);
}

}  // namespace
}  // namespace facetloc::test
