// SPDX-License-Identifier: BSD-3-Clause
#include "example_room.h"
#include "tools/map_apps.h"

#include <facetloc/io/map_database.h>

#include <gmock/gmock.h>

#include <sstream>

namespace facetloc {
namespace {

namespace fs = std::filesystem;
using test::filesOf;
using test::runMap;
using test::Tools;
using testing::HasSubstr;

TEST_F(Tools, MapMergeAndExport) {
  const std::string twin = folder_ / "twin.flmap", merged = folder_ / "merged.flmap";
  fs::copy_file(map(), twin);
  ASSERT_EQ(runMap({"merge", map(), twin, "-o", merged}).code, kOk);
  const Map one = readMap(map()), both = readMap(merged);
  ASSERT_EQ(both.models.size(), 2 * one.models.size());
  EXPECT_EQ(both.links.size(), 2 * one.links.size());
  EXPECT_EQ(both.models[0].name, "map_" + one.models[0].name);
  EXPECT_EQ(both.models[one.models.size()].name, "twin_" + one.models[0].name);
  EXPECT_TRUE(both.camera.mounting);
  EXPECT_EQ(runMap({"merge", map(), "-o", merged}).code, kFailed);  // exists
  EXPECT_EQ(runMap({"merge", map(), map(), "-o", folder_ / "x.flmap"}).code, kFailed);

  const std::string alike = folder_ / "other/map.flmap";
  fs::create_directories(folder_ / "other");
  ASSERT_EQ(runMap({"build", query(), "-o", alike, "--every", "6"}).code, kOk);
  ASSERT_EQ(runMap({"merge", map(), alike, "-o", folder_ / "both.flmap", "--same-coordinates"}).code, kOk);
  const Map of_both = readMap(folder_ / "both.flmap");
  EXPECT_NE(of_both.meta.at("map.source"), of_both.meta.at("map_2.source"));

  ASSERT_EQ(runMap({"export", map(), "-o", folder_ / "export"}).code, kOk);
  const auto exported = [this] { return filesOf(folder_ / "export/models").size(); };
  const std::size_t models = exported();
  ASSERT_EQ(runMap({"export", alike, "-o", folder_ / "export"}).code, kOk);
  EXPECT_EQ(exported(), 2u);
  EXPECT_GT(models, 2u);
  EXPECT_TRUE(fs::exists(folder_ / "export/graph.g2o"));
}

TEST_F(Tools, MapCommandsAreKnown) {
  EXPECT_EQ(runMap({}).code, kUsage);
  EXPECT_EQ(runMap({"biuld"}).code, kUsage);
  for (const char* option : {"--help", "-help", "-h", "--version", "-version"}) {
    EXPECT_EQ(runMap({option}).code, kOk) << option;
    std::ostringstream full, err;
    full.setstate(std::ios::badbit);
    EXPECT_EQ(runMapTool({option}, Console{full, err, false, false, {}}), kFailed) << option;
    EXPECT_THAT(err.str(), HasSubstr("cannot be written"));
  }
  test::writeContent(folder_ / "broken.flmap", "not a map");
  EXPECT_EQ(runMap({"check", folder_ / "broken.flmap"}).code, kFailed);
  EXPECT_EQ(runMap({"info", folder_ / "broken.flmap"}).code, kFailed);
}

}  // namespace
}  // namespace facetloc
