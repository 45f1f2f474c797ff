// SPDX-License-Identifier: BSD-3-Clause
#include "box_mesh.h"
#include "ranking/global_localization.h"

#include <facetloc/features/map_metadata.h>
#include <facetloc/features/pose.h>
#include <facetloc/mapping/map_session.h>
#include <facetloc/mapping/mesh_surface.h>
#include <facetloc/mapping/model_map.h>
#include <facetloc/segmentation/view_builder.h>

#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <vector>

namespace facetloc {
namespace {

constexpr float kApart = 10;  // distance between the rooms [m]

Camera robotCamera() {
  Camera camera;
  camera.intrinsics = kinectIntrinsics().subsampled(2);
  camera.mounting = CameraMounting{1, 5};
  return camera;
}

void addRoom(float x, BoxMesh& mesh) {
  constexpr float w = 0.2f, h = 2.5f, length = 4;
  mesh.add({x - w, -w, -w}, {x + length + w, length + w, 0})
      .add({x - w, -w, h}, {x + length + w, length + w, h + w})
      .add({x - w, -w, 0}, {x, length + w, h})
      .add({x + length, -w, 0}, {x + length + w, length + w, h})
      .add({x, -w, 0}, {x + length, 0, h})
      .add({x, length, 0}, {x + length, length + w, h})
      .add({x + 3.2f, 2.9f, 0}, {x + 4, 4, 0.75f});
}

/** Two equal rooms, except for a wardrobe built into the second one. */
BoxMesh building() {
  BoxMesh mesh;
  addRoom(0, mesh);
  addRoom(kApart, mesh);
  return mesh.add({kApart + 1, 3.5f, 0}, {kApart + 2.3f, 4, 2.1f});
}

/** A robot in one of the rooms. */
Eigen::Isometry3d cameraAt(double x, double y, double heading_deg) {
  return Eigen::Translation3d(x, y, 0) * Eigen::AngleAxisd(heading_deg * kDegree, Eigen::Vector3d::UnitZ()) *
         robotCamera().mounting->T_b_c();
}

Map mapOf(const std::shared_ptr<const Surface>& surface, const std::vector<Eigen::Isometry3d>& viewpoints) {
  ModelMap making(surface, robotCamera());
  making.setViewpoints(viewpoints);
  making.setNumberOfThreads(2);
  return making.finish();
}

std::vector<Eigen::Isometry3d> viewpointsInBothRooms() {
  std::vector<Eigen::Isometry3d> viewpoints;
  for (const double room : {0.0, double(kApart)})
    for (const double x : {1.2, 2.0, 2.8})
      for (int heading = 10; heading < 360; heading += 40)
        viewpoints.push_back(cameraAt(room + x, 1, heading));
  return viewpoints;
}

const Map& mapOfBuilding() {
  static const Map map =
      mapOf(std::make_shared<const MeshSurface>(building().mesh()), viewpointsInBothRooms());
  return map;
}

/** How often a robot in the first room, into which something narrower than that wardrobe has been moved, is
 * found there. */
int foundIn(const Map& map) {
  const MeshSurface furnished(building().add({1.05f, 3.5f, 0}, {1.65f, 4, 2.1f}).mesh());
  const internal::GlobalLocalization localization(unowned(map));
  ViewBuilder builder(robotCamera());
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, DepthNoise().inverse_depth_std);
  int found = 0;
  for (const double x : {1.4, 1.9, 2.4})
    for (const double heading : {85, 100}) {
      const Eigen::Isometry3d T_w_c = cameraAt(x, 0.8, heading);
      DepthImage image = furnished.render(robotCamera().intrinsics, T_w_c);
      for (float& z : image.depth)
        if (z > 0) z = static_cast<float>(1 / (1 / z + noise(random)));
      const Localization answer = localization.localize(builder.build(image));
      const bool is_right =
          !answer.hypotheses.empty() && isNear(*answer.hypotheses.front().T_w_c, T_w_c, 0.2, 2);
      EXPECT_TRUE(is_right || answer.state != AnswerState::sure) << x << " m, " << heading << " deg";
      found += is_right;
    }
  return found;
}

TEST(DrawnModels, WhatIsMovedInObjectsLessThanWhatWouldHaveToBeMissing) {
  EXPECT_EQ(MapSurfaces::fixed, surfacesOf(mapOfBuilding()));
  Map as_seen = mapOfBuilding();
  setSurfaces(MapSurfaces::seen, as_seen);
  EXPECT_GE(foundIn(mapOfBuilding()), 5);
  EXPECT_LE(foundIn(as_seen), 2);  // half of the wardrobe may have been moved away
}

/** A surface that a scanner has seen. */
class ScannedRooms : public Surface {
public:
  DepthImage render(const Intrinsics& camera, const Eigen::Isometry3d& T_w_c) const override {
    return mesh_.render(camera, T_w_c);
  }
  Eigen::AlignedBox3d bounds() const override { return mesh_.bounds(); }

private:
  MeshSurface mesh_{building().mesh()};
};

TEST(DrawnModels, ScansHoldWhatMayBeMovedAway) {
  EXPECT_EQ(MapSurfaces::seen,
            surfacesOf(mapOf(std::make_shared<const ScannedRooms>(), {cameraAt(2, 1, 90)})));
}

TEST(DrawnModels, AMergedMapIsOfWhatStaysIfBothAre) {
  Map seen = mapOfBuilding();
  setSurfaces(MapSurfaces::seen, seen);
  Map plan = mapOfBuilding();
  setSurfaces(MapSurfaces::incomplete, plan);
  const Map& fixed = mapOfBuilding();
  EXPECT_EQ(MapSurfaces::fixed, surfacesOf(mergedMap({fixed, fixed}, {"a", "b"})));
  EXPECT_EQ(MapSurfaces::seen, surfacesOf(mergedMap({fixed, seen}, {"a", "b"})));
  EXPECT_EQ(MapSurfaces::incomplete, surfacesOf(mergedMap({seen, plan}, {"a", "b"})));
}

}  // namespace
}  // namespace facetloc
