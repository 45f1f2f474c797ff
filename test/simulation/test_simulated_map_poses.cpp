// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/pose.h>
#include <facetloc/simulation/simulated_sensors.h>

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace facetloc {
namespace {

/** Straight on, 0.1 m a step, to and fro. */
std::vector<Eigen::Isometry3d> drive(int n) {
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < n; ++i)
    poses.emplace_back(Eigen::Translation3d(0.1 * (i < n / 2 ? i : n - i), 1, 2) *
                       Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY()));
  return poses;
}

MapPoseErrors errors() {
  MapPoseErrors errors;
  errors.translation_std = 0.03, errors.rotation_std_deg = 1;
  return errors;
}

TEST(SimulatedMapPoses, HaveErrorsOfThatSize) {
  const auto truth = drive(20000), poses = simulateMapPoses(truth, errors(), 3);
  ASSERT_EQ(poses.size(), truth.size());
  Vector6d squares = Vector6d::Zero();
  for (std::size_t i = 0; i < truth.size(); ++i)
    squares += boxminus(poses[i], truth[i]).cwiseAbs2() / static_cast<double>(truth.size());
  for (int axis = 0; axis < 6; ++axis)
    EXPECT_NEAR(std::sqrt(squares[axis]) / (axis < 3 ? kDegree : 0.03), 1, 0.1) << axis;
}

TEST(SimulatedMapPoses, AgreeWithTheirNeighboursAndNotWhereAPlaceIsPassedAgain) {
  const auto truth = drive(2000), poses = simulateMapPoses(truth, errors(), 3);
  double step = 0, again = 0;
  for (std::size_t i = 1; i < truth.size() / 2; ++i) {
    const auto error = [&](std::size_t k) {
      return (poses[k].translation() - truth[k].translation()).eval();
    };
    step = std::max(step, (error(i) - error(i - 1)).norm());
    again += (error(i) - error(truth.size() - i)).norm() / (truth.size() / 2.0 - 1);
  }
  EXPECT_LT(step, 0.02) << "0.1 m of waves of 3 m and more";
  EXPECT_GT(again, 0.03);
}

TEST(SimulatedMapPoses, SameSeedSameErrors) {
  const auto truth = drive(50);
  const auto a = simulateMapPoses(truth, errors(), 3), b = simulateMapPoses(truth, errors(), 3);
  const auto c = simulateMapPoses(truth, errors(), 4);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    EXPECT_EQ(a[i].matrix(), b[i].matrix());
    EXPECT_NE(a[i].matrix(), c[i].matrix());
  }
}

TEST(SimulatedMapPoses, WithoutErrorsTheyAreTrue) {
  const auto truth = drive(50), poses = simulateMapPoses(truth, {}, 3);
  EXPECT_FALSE(MapPoseErrors().any());
  for (std::size_t i = 0; i < truth.size(); ++i) EXPECT_TRUE(poses[i].isApprox(truth[i], 1e-14));
  MapPoseErrors negative;
  negative.translation_std = -1;
  EXPECT_THROW(simulateMapPoses(truth, negative, 3), std::invalid_argument);
}

}  // namespace
}  // namespace facetloc
