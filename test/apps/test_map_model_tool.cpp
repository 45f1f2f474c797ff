// SPDX-License-Identifier: BSD-3-Clause
#include "example_room.h"
#include "tool_runner.h"

#include <facetloc/features/map_metadata.h>
#include <facetloc/io/map_database.h>
#include <facetloc/io/occupancy_grid_file.h>

namespace facetloc::test {
namespace {

/** A room of 5 x 4 x 2.5 m as an OBJ file, in units of 1 / per_metre m, with the y axis up. */
void writeRoom(const fs::path& path, double per_metre) {
  std::ofstream out(path);
  const double size[] = {5, 2.5, 4};
  for (int i = 0; i < 8; ++i)
    out << "v " << (i & 1) * size[0] * per_metre << " " << (i >> 1 & 1) * size[1] * per_metre << " "
        << (i >> 2 & 1) * size[2] * per_metre << "\n";
  out << "f 1 2 4 3\nf 5 6 8 7\nf 1 2 6 5\nf 3 4 8 7\nf 1 3 7 5\nf 2 4 8 6\n";
}

TEST_F(Tools, ModelBecomesAMap) {
  const fs::path model(folder_ / "room.obj");
  writeRoom(model, 1000);
  const std::string map = folder_ / "room.flmap";
  const auto made = ok(runMap({"from-model", model.string(), "-o", map, "--units", "mm", "--up", "y",
                               "--height", "1", "--spacing", "2"}));
  EXPECT_THAT(made.out, HasSubstr("12 triangles of 5.00 x 2.50 x 4.00 m"));
  ok(runMap({"check", map}));
  EXPECT_THAT(runMap({"info", map}).out, HasSubstr("made of: a model"));
  const Map read = readMap(map);
  ASSERT_FALSE(read.models.empty());
  for (const LocalModel& m : read.models) {
    EXPECT_NEAR(m.T_w_m->translation().y(), 1, 1e-3);
    EXPECT_GT(m.T_w_m->translation().x(), 0);
    EXPECT_LT(m.T_w_m->translation().x(), 5);
  }
  EXPECT_THAT(runMap({"from-model", model.string(), "-o", map}).err, HasSubstr("exists already"));
}

TEST_F(Tools, ModelUpsideDownIsNamed) {
  const fs::path model(folder_ / "open.obj");
  std::ofstream(model) << "v 0 0 0\nv 5 0 0\nv 0 0 4\nv 5 0 4\nv 0 2.5 0\nv 5 2.5 0\nv 0 2.5 4\nv 5 2.5 4\n"
                          "f 1 2 4 3\nf 1 2 6 5\nf 3 4 8 7\nf 1 3 7 5\nf 2 4 8 6\n";  // without a ceiling
  const auto saidOf = [&](const std::string& up) {
    const auto made = runMap({"from-model", model.string(), "-o", folder_ / "turned.flmap", "--overwrite",
                              "--up=" + up, "--spacing", "3", "--turn_deg", "60"});
    return made.out + made.err;
  };
  EXPECT_THAT(saidOf("-y"), HasAll("upside down", "--up=y"));
  EXPECT_THAT(saidOf("z"), HasSubstr("its floors do not face z"));
  EXPECT_THAT(saidOf("0,1,0.1"), HasSubstr("its floor is inclined by 5.7 deg: --up=y levels it"));
  EXPECT_THAT(saidOf("y"), Not(HasSubstr("up")));
  EXPECT_THAT(saidOf("auto"), HasSubstr("the upward direction is y\n"));
  EXPECT_THAT(runMap({"info", folder_ / "turned.flmap", "--all"}).out, HasSubstr("up = y"));
}

TEST_F(Tools, ModelWithoutAClearUpwardDirectionAsksForIt) {
  const fs::path model(folder_ / "cube.obj");
  std::ofstream(model) << "v 0 0 0\nv 3 0 0\nv 0 3 0\nv 3 3 0\nv 0 0 3\nv 3 0 3\nv 0 3 3\nv 3 3 3\n"
                          "f 1 2 4 3\nf 5 6 8 7\nf 1 2 6 5\nf 3 4 8 7\nf 1 3 7 5\nf 2 4 8 6\n";
  const auto made = runMap({"from-model", model.string(), "-o", folder_ / "cube.flmap", "--up", "auto"});
  EXPECT_THAT(made, fails("do not show which direction is up"));
  for (const char* option : {"--up=x", "--up=y", "--up=z"}) EXPECT_THAT(made.err, HasSubstr(option));
  const auto closed = runMap(
      {"from-model", model.string(), "-o", folder_ / "cube.flmap", "--spacing", "3", "--turn_deg", "60"});
  EXPECT_THAT(closed.out + closed.err, Not(HasSubstr("--up")));
}

TEST_F(Tools, ModelOfItsKindsConventionIsNotContradicted) {
  const fs::path model(folder_ / "room.obj");
  writeRoom(model, 1);
  const auto saidOf = [&](const std::string& up) {
    const auto made = runMap({"from-model", model.string(), "-o", folder_ / "kind.flmap", "--overwrite",
                              "--up=" + up, "--spacing", "3", "--turn_deg", "60"});
    return made.out + made.err;
  };
  EXPECT_THAT(saidOf("y"), Not(HasSubstr("its floors do not face")));
  EXPECT_THAT(saidOf("auto"), HasSubstr("the upward direction is y\n"));
}

TEST_F(Tools, ModelInAnotherUnitIsRemarked) {
  const fs::path model(folder_ / "room.obj");
  const fs::path viewpoints(folder_ / "poses.txt");  // one, so that nothing large is searched
  const auto saidOf = [&](double per_metre, const std::string& unit) {
    writeRoom(model, per_metre);
    std::ofstream(viewpoints) << "0 2 1 2 0 0 0 1\n";
    const auto made = runMap({"from-model", model.string(), "-o", folder_ / "units.flmap", "--overwrite",
                              "--units", unit, "--viewpoints", viewpoints.string()});
    return made.out + made.err;
  };
  EXPECT_THAT(saidOf(1, "m"), Not(HasSubstr("--units")));
  EXPECT_THAT(saidOf(1000, "mm"), Not(HasSubstr("--units")));
  EXPECT_THAT(saidOf(1000, "m"), HasSubstr("its rooms are 2500 m high; is its unit mm? --units mm"));
  EXPECT_THAT(saidOf(100, "m"), HasSubstr("its rooms are 250 m high; is its unit cm? --units cm"));
  EXPECT_THAT(saidOf(1 / 0.0254, "m"), HasSubstr("its rooms are 98 m high; is its unit in? --units in"));
  EXPECT_THAT(saidOf(1, "mm"), HasSubstr("it is only 0.005 x 0.0025 x 0.004 m large; is its unit m?"));
  EXPECT_THAT(saidOf(1, "in"), HasSubstr("is its unit m? --units m"));
}

TEST_F(Tools, ModelsOfImpossibleSizeAreRefusedBeforeTheWork) {
  const fs::path model(folder_ / "room.obj");
  const fs::path viewpoints(folder_ / "poses.txt");
  std::ofstream(viewpoints) << "0 2 1 2 0 0 0 1\n";
  const std::string map = folder_ / "size.flmap", findings = folder_ / "findings.json";
  const auto made = [&](double per_metre, const Arguments& more) {
    writeRoom(model, per_metre);
    return runMap(Arguments{"from-model", model.string(), "-o", map, "--overwrite", "--findings", findings} +
                  more);
  };
  const std::string given = viewpoints.string(), refused = "cannot be right as it is read";
  for (const auto& [per_metre, words] :
       {std::pair<double, std::string>{1000, "its rooms are 2500 m high; is its unit mm? --units mm"},
        {100, "its rooms are 250 m high; is its unit cm? --units cm"},
        {1 / 0.0254, "its rooms are 98 m high; is its unit in? --units in"},
        {0.001, "it is only 0.005 x 0.0025 x 0.004 m large"}}) {
    fs::remove(map);
    EXPECT_THAT(made(per_metre, {"--viewpoints", given}), fails(refused, words, "--units m or --force"));
    EXPECT_FALSE(fs::exists(map) && fs::file_size(map) > 0);
    EXPECT_THAT(contentOf(findings), HasAll("model.units", "refusal"));
    for (const std::vector<std::string>& meant : {std::vector<std::string>{"--force"}, {"--units", "m"}}) {
      const auto forced = made(per_metre, Arguments{"--viewpoints", given} + meant);
      EXPECT_THAT(forced.err, HasSubstr(words));
      EXPECT_THAT(forced.err, Not(HasSubstr(refused)));
    }
  }
  EXPECT_THAT(made(10, {"--viewpoints", given}).err, HasAll("25 m high", Not(HasSubstr(refused))));
  EXPECT_THAT(made(3, {"--up", "y", "--spacing", "0.1"}),
              fails("a camera can be at about", "more than 20000", "--spacing 0.5", "--force"));
}

TEST_F(Tools, ModelOptionsThatViewpointsMakeUselessAreRefused) {
  const fs::path model(folder_ / "room.obj");
  writeRoom(model, 1);
  for (const std::vector<std::string>& option :
       {std::vector<std::string>{"--height", "1"}, {"--up", "y"}, {"--inside", "1,1,1"}}) {
    EXPECT_THAT(runMap({"from-model", model.string(), "-o", folder_ / "no.flmap", "--viewpoints",
                        folder_ / "poses.txt", option[0], option[1]}),
                refuses("viewpoints names them"));
  }
}

TEST_F(Tools, AnInvalidModelLeavesNoMap) {
  const std::string map = folder_ / "none.flmap";
  const fs::path model(folder_ / "sheet.obj");
  std::ofstream(model) << "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n";
  EXPECT_THAT(runMap({"from-model", model.string(), "-o", map}).err, HasSubstr("no triangle with an area"));
  writeRoom(model, 1000);
  EXPECT_THAT(runMap({"from-model", model.string(), "-o", map, "--units", "km"}).err,
              HasSubstr("is not one of m, cm"));
  EXPECT_THAT(runMap({"from-model", model.string(), "-o", map, "--up", "1,2"}).err,
              HasSubstr("neither an axis"));
  EXPECT_FALSE(fs::exists(map) && fs::file_size(map) > 0);
}

using FloorPlanTools = InAFolder;

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
  std::string yaml = contentOf(folder_ / "hotel.yaml");
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
