// SPDX-License-Identifier: BSD-3-Clause
#include "tool_runner.h"

#include <facetloc/features/map_metadata.h>
#include <facetloc/io/map_database.h>
#include <facetloc/io/occupancy_grid_file.h>

namespace facetloc::test {
namespace {

class FloorPlanTools : public testing::Test {
protected:
  TemporaryFolder folder_;
};

/** A plan becomes a map, and the map a plan. */
TEST_F(FloorPlanTools, FloorPlansGoBothWays) {
  const std::string plan = folder_ / "hotel.yaml", map = folder_ / "hotel.flmap";
  ok(runTool<simulateApp>({"hotel", "--grid", folder_ / "hotel"}));
  std::ofstream(folder_ / "poses.txt") << "0 2.2 0 1 -0.5 0.5 -0.5 0.5\n1 6.6 0 1 -0.5 0.5 -0.5 0.5\n"
                                          "2 11 0 1 0.5 0.5 -0.5 -0.5\n3 15.4 0 1 0.5 0.5 -0.5 -0.5\n";
  EXPECT_THAT(ok(runTool<mapModelApp>(
                     {plan, "-o", map, "--wall-height", "2.5", "--viewpoints", folder_ / "poses.txt"}))
                  .out,
              HasSubstr("2.50 m high"));
  const Map read = openMap(map);
  EXPECT_EQ(read.models.size(), 4u);
  EXPECT_TRUE(lacksSurfaces(read));
  EXPECT_THAT(runTool<mapInfoApp>({map}).out, HasSubstr("a floor plan"));

  const ToolRun back =
      ok(runTool<mapExportApp>({map, "--grid", folder_ / "back/", "--grid.resolution", "0.1"}));
  const OccupancyGrid grid = readOccupancyGrid(folder_ / "back/map.yaml"), truth = readOccupancyGrid(plan);
  int walls = 0, wrong = 0;
  for (int row = 0; row < grid.height; ++row)
    for (int column = 0; column < grid.width; ++column) {
      if (!grid.isOccupied(column, row)) continue;
      const Eigen::Vector2d cell = truth.cellOf(grid.centre(column, row));
      bool near = false;
      for (int i = 0; i < 25; ++i)
        near |=
            truth.isOccupied(static_cast<int>(cell.x()) + i % 5 - 2, static_cast<int>(cell.y()) + i / 5 - 2);
      ++walls;
      wrong += !near;
    }
  EXPECT_GT(walls, 100);
  EXPECT_EQ(wrong, 0) << "of " << walls;
}

TEST_F(FloorPlanTools, UnknownCellsThatCountAsFreeAreNamed) {
  ok(runTool<simulateApp>({"hotel", "--grid", folder_ / "hotel"}));
  std::ifstream in(folder_ / "hotel.yaml");
  std::string yaml{std::istreambuf_iterator<char>(in), {}};
  yaml.replace(yaml.find("0.196"), 5, "0.25");
  std::ofstream(folder_ / "generous.yaml") << yaml;
  std::ofstream(folder_ / "pose.txt") << "0 2.2 0 1 -0.5 0.5 -0.5 0.5\n";
  for (const char* plan : {"hotel.yaml", "generous.yaml"}) {
    const ToolRun made =
        ok(runTool<mapModelApp>({folder_ / plan, "-o", folder_ / "hotel.flmap", "--overwrite",
                                 "--wall-height", "2.5", "--viewpoints", folder_ / "pose.txt"}));
    const auto named = HasSubstr("the grey 205 of unknown ones, which free_thresh 0.25 counts as free");
    if (plan == std::string("generous.yaml"))
      EXPECT_THAT(made.err, named);
    else
      EXPECT_THAT(made.err, Not(HasSubstr("205")));
  }
}

TEST_F(FloorPlanTools, FloorPlansAreAskedForTheirHeight) {
  ok(runTool<simulateApp>({"hotel", "--grid", folder_ / "hotel"}));
  const std::string plan = folder_ / "hotel.yaml", map = folder_ / "hotel.flmap";
  EXPECT_THAT(ok(runTool<mapModelApp>({plan, "-o", folder_ / "usual.flmap"})).out, HasSubstr("2.50 m high"));
  EXPECT_EQ(runTool<mapModelApp>({"scan.ply", "-o", map, "--wall-height", "2"}).code, kUsage);
  std::ofstream(folder_ / "bad.yaml") << "image: hotel.pgm\nresolution: nan\norigin: [0, 0, 0]\n";
  EXPECT_THAT(runTool<mapModelApp>({folder_ / "bad.yaml", "-o", map, "--wall-height", "2"}),
              fails("resolution"));
  EXPECT_FALSE(std::filesystem::exists(map));
}

}  // namespace
}  // namespace facetloc::test
