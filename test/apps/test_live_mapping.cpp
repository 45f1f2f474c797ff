// SPDX-License-Identifier: BSD-3-Clause
// Maps that the live tool makes while it runs, and the file left by a killed one.
#include "live_tool.h"

#include <facetloc/io/map_database.h>
#include <facetloc/io/results.h>
#include <facetloc/io/trajectory.h>

namespace facetloc::test {
namespace {

std::string stateOf(const std::string& map) { return readMap(map).meta.at("state"); }

TEST_F(LiveTool, MakesAMapInWhichTheCameraIsFound) {
  const std::string made = folder_ / "made.flmap", results = folder_ / "results", again = folder_ / "again";
  const ToolRun run =
      ok(runLive({"--device", sequence(), "--headless", "--build", made, "--results", results}));
  EXPECT_THAT(run.out, HasAll("mapping", "map in " + made));
  expectWholeResults(results, 20);
  EXPECT_THAT(checkMap(made), IsEmpty());
  EXPECT_EQ(stateOf(made), "whole");

  const Map map = readMap(made);
  ASSERT_GE(map.models.size(), 5u);
  EXPECT_GE(map.links.size(), map.models.size() - 1);
  const Trajectory truth = readTrajectory(sequence() + "/groundtruth.txt");
  const auto trueAt = [&](double stamp) { return *truth.at(stamp, 1e-3); };
  const Eigen::Isometry3d T_true_w = trueAt(map.models.front().stamp) * map.models.front().T_w_m->inverse();
  for (const LocalModel& model : map.models) {
    ASSERT_TRUE(model.T_w_m) << model.name;
    const Eigen::Isometry3d T = T_true_w * *model.T_w_m;
    EXPECT_LT((T.translation() - trueAt(model.stamp).translation()).norm(), 0.1) << model.name;
  }

  ok(runLive({"--device", sequence(), "--headless", "--map", made, "--results", again}));
  const auto found = readTrajectory(again + "/poses_tum.txt").poses();
  EXPECT_GE(found.size(), 20u);
  for (const StampedPose& pose : found) {
    const Eigen::Isometry3d T = T_true_w * pose.T_w_c;
    EXPECT_LT((T.translation() - trueAt(pose.stamp).translation()).norm(), 0.1) << pose.stamp;
  }
}

TEST_F(LiveTool, LeavesAMapAloneUnlessItIsToBeReplaced) {
  const std::string made = folder_ / "made.flmap";
  const auto build = [&](std::vector<std::string> more) {
    return runLive(Arguments{"--device", sequence(), "--headless", "--build", made, "--speed", "4"} + more);
  };
  ok(build({}));
  const std::string before = contentOf(made);
  EXPECT_THAT(build({}), fails("exists already; --overwrite replaces it"));
  EXPECT_EQ(contentOf(made), before);
  ok(build({"--overwrite"}));
  EXPECT_THAT(checkMap(made), IsEmpty());
  EXPECT_EQ(build({"--map", map()}).code, kUsage);
}

TEST_F(LiveTool, AMapWhoseMakerIsStoppedIsWhole) {
  const std::string made = folder_ / "made.flmap", results = folder_ / "results";
  LiveProcess process(
      {"--device", sequence(), "--headless", "--repeat", "--build", made, "--results", results});
  ASSERT_TRUE(eventually([&] { return linesOf(results + "/states.csv").size() > 20; }));
  process.signal(SIGINT);
  ok(process.wait());
  EXPECT_THAT(checkMap(made), IsEmpty());
  EXPECT_EQ(stateOf(made), "whole");
  EXPECT_GE(readMap(made).models.size(), 2u);
}

TEST_F(LiveTool, AMapWhoseMakerIsKilledIsSound) {
  const std::string made = folder_ / "made.flmap", results = folder_ / "results";
  LiveProcess process(
      {"--device", sequence(), "--headless", "--repeat", "--build", made, "--results", results});
  ASSERT_TRUE(eventually([&] { return linesOf(results + "/states.csv").size() > 30; }));
  process.signal(SIGKILL);
  EXPECT_EQ(process.wait().code, 128 + SIGKILL);
  EXPECT_THAT(checkMap(made), IsEmpty());
  EXPECT_EQ(stateOf(made), "under way");
  EXPECT_GE(readMap(made).models.size(), 2u);
}

}  // namespace
}  // namespace facetloc::test
