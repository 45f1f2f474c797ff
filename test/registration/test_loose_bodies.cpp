// SPDX-License-Identifier: BSD-3-Clause
#include "depth/loose_bodies.h"

#include <facetloc/features/pose.h>
#include <facetloc/segmentation/view_builder.h>
#include <facetloc/simulation/simulated_camera.h>
#include <facetloc/simulation/simulated_drive.h>
#include <facetloc/simulation/simulated_people.h>

#include <gtest/gtest.h>

namespace facetloc {

using namespace internal;
namespace {

const Eigen::Isometry3d kCamera(DriveParams().mounting().T_b_c());  // looks along x
const DepthComparison kComparison{DepthCalibration()};

/** A hall of 8 m x 6 m, with a table of the size of a person. */
SimulatedWorld hall() {
  SimulatedWorld world;
  std::uint16_t id = 1;
  Eigen::Isometry3d T(Eigen::Translation3d(1, 0, 1.4));
  addBox(world, T, {4, 3, 1.4}, id);
  T.translation() << 3, -1, 0.4;
  addBox(world, T, {0.3, 0.5, 0.4}, id);
  return world;
}

SimulatedWorld withPerson(double x, double y, double heading_deg) {
  SimulatedWorld world = hall();
  Eigen::Isometry3d T(Eigen::AngleAxisd(heading_deg * kDegree, Eigen::Vector3d::UnitZ()));
  T.translation() << x, y, 0;
  world.bodies = simulatedPerson(T, 0.3, 3);
  return world;
}

View viewOf(const SimulatedWorld& world, std::uint64_t frame = 0) {
  const SimulatedCamera camera(centredKinect(320), {}, 1);
  return ViewBuilder().build(camera.render(world, kCamera, frame).depth);
}

/** Share of the pixels on the person, who is not in the empty hall, and of the others, that a picture has
 * lost. */
std::pair<double, double> lost(const DepthPicture& picture, const DepthPicture& whole,
                               const DepthPicture& empty) {
  double person = 0, of_person = 0, rest = 0, of_rest = 0;
  for (std::size_t i = 0; i < picture.inverse_depth.size(); ++i) {
    if (whole.inverse_depth[i] == 0 || empty.inverse_depth[i] == 0) continue;
    const bool is_nearer = whole.inverse_depth[i] > 1.05 * empty.inverse_depth[i];
    (is_nearer ? person : rest) += 1;
    (is_nearer ? of_person : of_rest) += picture.inverse_depth[i] == 0;
  }
  return {of_person / person, of_rest / rest};
}

TEST(LooseBodies, OfAnEmptyMapHideIt) {
  const View view = viewOf(withPerson(1.6, 0.2, 180)), empty = viewOf(hall(), 1);
  const LooseBodies bodies(view);
  ASSERT_FALSE(bodies.empty());
  const LooseBodies::Chosen hiding = bodies.before(kCamera, {{&empty.depth, kCamera}}, kComparison);
  const auto [person, others] = lost(bodies.pictureWithout(hiding), view.depth, empty.depth);
  EXPECT_GT(person, 0.95);
  EXPECT_LT(others, 0.1);
  EXPECT_FALSE(anyOf(bodies.before(kCamera, {{&view.depth, kCamera}}, kComparison)));
  const LooseBodies::Chosen furniture = bodies.shown(kCamera, {{&empty.depth, kCamera}}, kComparison);
  for (std::size_t k = 0; k < furniture.size(); ++k)
    EXPECT_NE(furniture[k], hiding[k]) << "the table, the person";
  EXPECT_TRUE(anyOf(bodies.shown(kCamera, {{&view.depth, kCamera}}, kComparison)));
}

TEST(LooseBodies, AreNoWallsAndNoFloor) {
  SimulatedWorld bare = hall();
  bare.rectangles.resize(6);
  EXPECT_TRUE(LooseBodies(viewOf(bare)).empty());
  EXPECT_TRUE(LooseBodies(View()).empty());
}

}  // namespace
}  // namespace facetloc
