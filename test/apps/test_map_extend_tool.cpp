// SPDX-License-Identifier: BSD-3-Clause
#include "example_room.h"

#include <facetloc/io/map_database.h>
#include <facetloc/io/trajectory.h>
#include <facetloc/testing/pose_matchers.h>

namespace facetloc::test {
namespace {

/** A room that is not in the map. */
std::string otherRoom(const std::string& folder) {
  ok(runTool<simulateApp>({"room", "-o", folder, "--seed", "9", "--frames", "12", "--width", "320"}));
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
  const ToolRun run = ok(runMap({"extend", map(), query(), "-o", path, "--trajectory", poses}));
  EXPECT_THAT(run.out, HasAll("the session is found in the map: ", "seen again, of whose "));
  EXPECT_THAT(lastLine(run.out), HasSubstr("; map of "));
  ok(runMap({"check", path}));
  const Map before = readMap(map()), extended = readMap(path);
  EXPECT_THAT(extended.meta.at("session 2"), HasSubstr("12 images"));
  EXPECT_EQ(extended.meta.at("source"), before.meta.at("source"));
  EXPECT_EQ(extended.ambiguity.has_value(), before.ambiguity.has_value());
  EXPECT_FALSE(readTrajectory(poses).empty());

  ok(runMap({"extend", path, query()}));
  const Map twice = readMap(path);
  EXPECT_EQ(twice.models.size(), extended.models.size());
  EXPECT_TRUE(twice.meta.count("session 3"));
  EXPECT_EQ(runMap({"extend", map(), query(), "-o", path}).code, kFailed);  // exists
  ok(runMap({"extend", map(), query(), "-o", path, "--overwrite"}));
  EXPECT_EQ(runMap({"extend", path, query(), "--overwrite"}).code, kUsage);
}

/** A thing in front of two local models, which no image of the session sees. */
Map withAThingInFront(Map map) {
  for (const std::size_t i : {0, 1}) {
    View view = *map.view(static_cast<int>(i));
    Segment nearer = view.segments.front();
    std::vector<std::uint16_t> picture = view.depth.inverse_depth;
    for (std::uint16_t& inverse : picture) inverse = static_cast<std::uint16_t>(1.5 * inverse);
    nearer.t /= 1.5;
    for (Eigen::Vector2f& corner : nearer.hull.vertex) corner /= 1.5F;
    const DepthNoise noise = view.depth.noise;
    view.segments = {nearer};
    view.depth = DepthPicture::fromStored(view.depth.camera, std::move(picture));
    view.depth.noise = noise;
    map.models[i].setView(std::move(view));
  }
  return map;
}

TEST_F(Tools, MapChangesListsSurfacesAndLeavesTheMap) {
  const std::string path = folder_ / "m.flmap", csv = folder_ / "changes.csv", page = folder_ / "c.html";
  const Arguments same = {"changes", map(), query(), "--csv", csv, "--page", page};
  EXPECT_THAT(ok(runMap(same)).out, HasAll("the session is found", "surfaces removed, ", "surfaces new, "));
  const std::string header = contentOf(csv);
  EXPECT_THAT(header, HasSubstr("surface,area_m2,probability,looks,part,seen_by,x,y,z,nx,ny,nz,outline\n"));

  writeMap(path, withAThingInFront(readMap(map())));
  const std::string content = contentOf(path);
  EXPECT_THAT(ok(runMap({"changes", path, query(), "--csv", csv, "--page", page})).out,
              HasSubstr("removed "));
  EXPECT_EQ(contentOf(path), content);
  EXPECT_THAT(contentOf(csv), HasSubstr("\nremoved,"));
  EXPECT_THAT(contentOf(page), HasSubstr("\"kind\":\"removed\""));
  EXPECT_THAT(ok(runMap({"extend", path, query(), "-o", folder_ / "n.flmap"})).out, HasSubstr("removed "));
  EXPECT_THAT(runMap({"changes", map(), otherRoom(folder_ / "other")}), fails("is not found in"));
}

TEST_F(Tools, MapExtendFindsASessionInCoordinatesOfItsOwn) {
  std::vector<StampedPose> moved;
  const Trajectory truth = readTrajectory(query() + "/groundtruth.txt");
  for (const StampedPose& p : truth.poses()) moved.push_back({p.stamp, kMove * p.T_w_c});
  const std::string poses = folder_ / "poses.txt", found = folder_ / "found.txt";
  writeTumTrajectory(poses, moved);
  ok(runMap({"extend", map(), query(), "-o", folder_ / "m.flmap", "--poses", poses, "--trajectory", found}));
  const Trajectory in_map = readTrajectory(found);
  EXPECT_FALSE(in_map.empty());
  for (const StampedPose& p : in_map.poses()) EXPECT_THAT(p.T_w_c, PoseNear(*truth.at(p.stamp), 0.05, 1));
}

TEST_F(Tools, MapExtendRefusesASessionOfAnotherPlaceAndLeavesTheMap) {
  const std::string path = folder_ / "m.flmap", other = otherRoom(folder_ / "other");
  fs::copy_file(map(), path);
  const std::string content = contentOf(path);
  EXPECT_THAT(runMap({"extend", path, other}), fails("is not found in " + path, "3 must"));
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
  EXPECT_THAT(ok(runMap({"merge", map(), moved, "-o", both})).out, HasSubstr("and moves by "));
  const Map merged = readMap(both);
  const std::size_t n = one.models.size();
  ASSERT_EQ(merged.models.size(), 2 * n);
  for (std::size_t i = 0; i < n; ++i)
    EXPECT_THAT(*merged.models[n + i].T_w_m, PoseNear(*one.models[i].T_w_m, 0.05, 1)) << i;
  ok(runMap({"merge", map(), moved, "-o", both, "--same-coordinates", "--overwrite"}));
  EXPECT_THAT(*readMap(both).models[n].T_w_m, PoseNear(kMove * *one.models[0].T_w_m, 1e-6, 1e-6));
}

TEST_F(Tools, MapMergeRefusesMapsThatHaveNoPlaceInCommon) {
  const std::string other = folder_ / "other.flmap", both = folder_ / "both.flmap";
  ok(runMap({"build", otherRoom(folder_ / "other"), "-o", other, "--map.distance", "0.1"}));
  EXPECT_THAT(runMap({"merge", map(), other, "-o", both}),
              fails("is not found in the maps before it", "--same-coordinates"));
  ok(runMap({"merge", map(), other, "-o", both, "--same-coordinates"}));
}

}  // namespace
}  // namespace facetloc::test
