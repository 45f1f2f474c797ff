// SPDX-License-Identifier: BSD-3-Clause
#include "example_room.h"
#include "tools/map_apps.h"
#include "tools/simulate_app.h"

#include <facetloc/io/map_database.h>
#include <facetloc/io/trajectory.h>
#include <facetloc/testing/pose_matchers.h>

#include <gmock/gmock.h>

namespace facetloc {
namespace {

namespace fs = std::filesystem;
using test::contentOf;
using test::lastLine;
using test::PoseNear;
using test::runMap;
using test::runTool;
using test::ToolRun;
using test::Tools;
using testing::HasSubstr;

/** A room that is not in the map. */
std::string otherRoom(const std::string& folder) {
  EXPECT_EQ(
      runTool<SimulateApp>({"room", "-o", folder, "--seed", "9", "--frames", "12", "--width", "320"}).code,
      kOk);
  return folder + "/query";
}

/** The same map with coordinates of its own. */
void writeMoved(const std::string& path, Map map, const Eigen::Isometry3d& T) {
  for (LocalModel& model : map.models) model.T_w_m = T * *model.T_w_m;
  writeMap(path, map);
}

const Eigen::Isometry3d kMove =
    Eigen::Translation3d(20, -7, 0.5) * Eigen::AngleAxisd(2, Eigen::Vector3d::UnitZ());

TEST_F(Tools, MapExtendBringsAMapUpToDateOnce) {
  const std::string path = folder_ / "m.flmap", poses = folder_ / "poses.txt";
  const ToolRun run = runMap({"extend", map(), query(), "-o", path, "--trajectory", poses});
  ASSERT_EQ(run.code, kOk) << run.err;
  EXPECT_THAT(run.out, HasSubstr("the session is found in the map: "));
  EXPECT_THAT(run.out, HasSubstr("seen again, of whose "));
  EXPECT_THAT(lastLine(run.out), HasSubstr("; map of "));
  EXPECT_EQ(runMap({"check", path}).code, kOk);
  const Map before = readMap(map()), extended = readMap(path);
  EXPECT_THAT(extended.meta.at("session 2"), HasSubstr("12 images"));
  EXPECT_EQ(extended.meta.at("source"), before.meta.at("source"));
  EXPECT_EQ(extended.ambiguity.has_value(), before.ambiguity.has_value());
  EXPECT_FALSE(readTumTrajectory(poses).empty());

  const ToolRun again = runMap({"extend", path, query()});
  ASSERT_EQ(again.code, kOk) << again.err;
  const Map twice = readMap(path);
  EXPECT_EQ(twice.models.size(), extended.models.size());
  EXPECT_TRUE(twice.meta.count("session 3"));
  EXPECT_EQ(runMap({"extend", map(), query(), "-o", path}).code, kFailed);  // exists
  EXPECT_EQ(runMap({"extend", map(), query(), "-o", path, "--overwrite"}).code, kOk);
  EXPECT_EQ(runMap({"extend", path, query(), "--overwrite"}).code, kUsage);
}

TEST_F(Tools, MapExtendFindsASessionInCoordinatesOfItsOwn) {
  std::vector<StampedPose> moved;
  const Trajectory truth = readTumTrajectory(query() + "/groundtruth.txt");
  for (const StampedPose& p : truth.poses()) moved.push_back({p.stamp, kMove * p.T_w_c});
  const std::string poses = folder_ / "poses.txt", found = folder_ / "found.txt";
  writeTumTrajectory(poses, moved);
  const ToolRun run =
      runMap({"extend", map(), query(), "-o", folder_ / "m.flmap", "--poses", poses, "--trajectory", found});
  ASSERT_EQ(run.code, kOk) << run.err;
  const Trajectory in_map = readTumTrajectory(found);
  EXPECT_FALSE(in_map.empty());
  for (const StampedPose& p : in_map.poses()) EXPECT_THAT(p.T_w_c, PoseNear(*truth.at(p.stamp), 0.05, 1));
}

TEST_F(Tools, MapExtendRefusesASessionOfAnotherPlaceAndLeavesTheMap) {
  const std::string path = folder_ / "m.flmap", other = otherRoom(folder_ / "other");
  fs::copy_file(map(), path);
  const std::string content = contentOf(path);
  const ToolRun run = runMap({"extend", path, other});
  EXPECT_EQ(run.code, kFailed);
  EXPECT_THAT(run.err, HasSubstr("is not found in " + path));
  EXPECT_THAT(run.err, HasSubstr("3 must"));
  EXPECT_EQ(contentOf(path), content);
}

TEST_F(Tools, MapExtendRefusesSenselessOptions) {
  const std::string missing = folder_ / "missing.flmap", path = folder_ / "m.flmap";
  EXPECT_EQ(runMap({"extend", missing, query()}).code, kFailed);
  EXPECT_FALSE(fs::exists(missing));
  EXPECT_EQ(runMap({"extend", map(), query(), "-o", path, "--without-poses", "--poses", "p.txt"}).code,
            kUsage);
  EXPECT_EQ(runMap({"extend", map(), folder_ / "nothing", "-o", path}).code, kFailed);
  Map without = readMap(map());
  for (LocalModel& model : without.models) model.T_w_m.reset();
  writeMap(path, without);
  EXPECT_THAT(runMap({"extend", path, query()}).err, HasSubstr("no local model has a pose"));
}

TEST_F(Tools, MapMergeAlignsMapsWithoutCommonCoordinates) {
  const std::string moved = folder_ / "moved.flmap", both = folder_ / "both.flmap";
  const Map one = readMap(map());
  writeMoved(moved, one, kMove);
  const ToolRun run = runMap({"merge", map(), moved, "-o", both});
  ASSERT_EQ(run.code, kOk) << run.err;
  EXPECT_THAT(run.out, HasSubstr("and moves by "));
  const Map merged = readMap(both);
  const std::size_t n = one.models.size();
  ASSERT_EQ(merged.models.size(), 2 * n);
  for (std::size_t i = 0; i < n; ++i)
    EXPECT_THAT(*merged.models[n + i].T_w_m, PoseNear(*one.models[i].T_w_m, 0.05, 1)) << i;
  const ToolRun same = runMap({"merge", map(), moved, "-o", both, "--same-coordinates", "--overwrite"});
  ASSERT_EQ(same.code, kOk) << same.err;
  EXPECT_THAT(*readMap(both).models[n].T_w_m, PoseNear(kMove * *one.models[0].T_w_m, 1e-6, 1e-6));
}

TEST_F(Tools, MapMergeRefusesMapsThatHaveNoPlaceInCommon) {
  const std::string other = folder_ / "other.flmap", both = folder_ / "both.flmap";
  ASSERT_EQ(runMap({"build", otherRoom(folder_ / "other"), "-o", other, "--map.distance", "0.1"}).code, kOk);
  const ToolRun run = runMap({"merge", map(), other, "-o", both});
  EXPECT_EQ(run.code, kFailed);
  EXPECT_THAT(run.err, HasSubstr("is not found in the maps before it"));
  EXPECT_THAT(run.err, HasSubstr("--same-coordinates"));
  EXPECT_EQ(runMap({"merge", map(), other, "-o", both, "--same-coordinates"}).code, kOk);
}

}  // namespace
}  // namespace facetloc
