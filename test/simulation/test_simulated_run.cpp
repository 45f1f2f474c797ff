// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/simulation/simulated_drive.h>

#include <gtest/gtest.h>

#include <stdexcept>

namespace facetloc {
namespace {

void expectSame(const std::vector<Eigen::Isometry3d>& a, const std::vector<Eigen::Isometry3d>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i].matrix(), b[i].matrix()) << i;
}

TEST(SimulatedRun, DrivesTheRouteOfItsRun) {
  const SimulatedPlace office = simulatedPlace("office", 3);
  expectSame(simulatedRun("office", 3, kMappingRun, 20, {}).poses,
             simulateDrive(office.mapping_route, 20, {}, 3 * 64));
  const SimulatedRun later = simulatedRun("office", 3, kLaterRun, 20, {});
  expectSame(later.poses, simulateDrive(office.query_route, 20, {}, 3 * 64 + 1));
  EXPECT_EQ(later.world.rectangles.size(), office.later.rectangles.size());
}

TEST(SimulatedRun, EndsWhereAOneWayRouteEndsUnlessItReturns) {
  const std::size_t frames = 1000;
  EXPECT_LT(simulatedRun("corridor", 1, kMappingRun, frames, {}).poses.size(), frames);
  EXPECT_EQ(simulatedRun("corridor", 1, kMappingRun, frames, {}, {}, RouteEnd::go_round).poses.size(),
            frames);
}

TEST(SimulatedRun, ARoomIsThatOfItsSeed) {
  const SimulatedRun run = simulatedRun(kRoomName, 5, kLaterRun, 10, {});
  EXPECT_EQ(run.world.rectangles.size(), furnishedRoom(5).rectangles.size());
  expectSame(run.poses, simulateDrive(furnishedRoom(5), 10, {}, runSeed(5, kLaterRun)));
  EXPECT_THROW(simulatedRun("cellar", 1, kMappingRun, 10, {}), std::invalid_argument);
}

TEST(SimulatedRun, TheKinectsCentreIsInTheMiddle) {
  const Intrinsics half = centredKinect(320);
  EXPECT_EQ(half.width, 320);
  EXPECT_EQ(half.height, 240);
  EXPECT_DOUBLE_EQ(half.cx, 159.5);
  EXPECT_DOUBLE_EQ(half.cy, 119.5);
  EXPECT_DOUBLE_EQ(half.fx, kinectIntrinsics().fx / 2);
}

}  // namespace
}  // namespace facetloc
