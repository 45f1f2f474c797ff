// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/pose.h>
#include <facetloc/simulation/simulated_camera.h>
#include <facetloc/simulation/simulated_place.h>

#include <gtest/gtest.h>

#include <cmath>

namespace facetloc {
namespace {

constexpr double kRoomWidth = 4.4;  // [m]

/** A camera in a room on the left or right of the corridor, or in front of its door. */
Eigen::Isometry3d poseIn(int room, double side, double across, double heading) {
  const double x = (room + 0.5) * kRoomWidth;
  Eigen::Isometry3d T = Eigen::Isometry3d(Eigen::Translation3d(x, side * across, 1.2));
  const double a = (side > 0 ? 1 : -1) * std::acos(-1.0) / 2 + heading;
  const Eigen::Vector3d z(std::cos(a), std::sin(a), 0), down(0, 0, -1);
  T.linear().col(2) = z;
  T.linear().col(1) = down;
  T.linear().col(0) = down.cross(z);
  return T;
}

double difference(const DepthImage& a, const DepthImage& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.depth.size(); ++i)
    most = std::max(most, std::abs(static_cast<double>(a.depth[i]) - static_cast<double>(b.depth[i])));
  return most;
}

TEST(EqualRooms, AreEqualInsideAndDifferInTheCorridor) {
  const SimulatedPlace place = simulatedPlace("hotel", 1);
  SimulatedNoise noise;
  const SimulatedCamera camera(kinectIntrinsics().subsampled(8), noise, 1);
  const auto seen = [&](int room, double side, double across, double heading) {
    return camera.render(place.mapped, poseIn(room, side, across, heading), 0).depth;  // with the same noise
  };
  for (const double heading : {0.0, 1.2, -1.2}) {  // not towards the door
    const DepthImage first = seen(0, 1, 3.5, heading);
    for (int room = 1; room < 6; ++room) EXPECT_LT(difference(first, seen(room, 1, 3.5, heading)), 0.2);
    EXPECT_LT(difference(first, seen(2, -1, 3.5, heading)), 0.2);
  }
  for (int room = 1; room < 6; ++room)
    EXPECT_GT(difference(seen(0, 1, -0.9, 0), seen(room, 1, -0.9, 0)), 0.2) << "their doors differ";
}

}  // namespace
}  // namespace facetloc
