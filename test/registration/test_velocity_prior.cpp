// SPDX-License-Identifier: BSD-3-Clause
#include "motion/step_prior.h"

#include <facetloc/testing/pose_matchers.h>

#include <gtest/gtest.h>

#include <vector>

namespace facetloc::internal {
namespace {

constexpr double kInterval = 0.5;  // [s]

/** One step of a camera that moves along its optical axis and turns about y. */
Eigen::Isometry3d step(double speed, double turn_deg = 0) {
  return Eigen::Translation3d(0, 0, speed * kInterval) *
         Eigen::AngleAxisd(turn_deg * kDegree, Eigen::Vector3d::UnitY());
}

TEST(VelocityPrior, IsAboutRestForACameraOfUnknownHabits) {
  VelocityPrior prior;
  EXPECT_EQ(prior.next(1, {}).T.matrix(), Eigen::Matrix4d::Identity());
  prior.add(step(1.2), kInterval);
  EXPECT_EQ(prior.keptShare(), 0) << "one motion says nothing of the next one";
  EXPECT_THAT(prior.next(1, {}).P, test::MatrixNear(motionPrior(1, {}), 1e-12));
}

TEST(VelocityPrior, ExpectsAWalkerToWalkOn) {
  VelocityPrior prior;
  for (int i = 0; i < 30; ++i) prior.add(step(1.2), kInterval);
  EXPECT_GT(prior.keptShare(), 0.95);
  EXPECT_THAT(prior.next(kInterval, {}).T.translation(),
              test::MatrixNear(prior.keptShare() * step(1.2).translation(), 1e-9));
}

TEST(VelocityPrior, ExpectsNothingOfACameraThatGoesToAndFro) {
  VelocityPrior prior;
  for (int i = 0; i < 30; ++i) prior.add(step(i % 2 == 0 ? 1 : -1), kInterval);
  EXPECT_EQ(prior.keptShare(), 0);
}

TEST(VelocityPrior, IsTheLeastSquaresShareOfTheMotions) {
  VelocityPrior prior;
  const std::vector<double> speeds{1, 0.8, 1.2, 0.1, 0.9, 1.1};
  double product = 0, square = 1.5;  // three motions that keep nothing
  for (std::size_t i = 0; i < speeds.size(); ++i) {
    prior.add(step(speeds[i]), kInterval);
    if (i > 0) product += speeds[i] * speeds[i - 1], square += speeds[i - 1] * speeds[i - 1];
  }
  EXPECT_NEAR(prior.keptShare(), product / square, 1e-12);
}

TEST(VelocityPrior, TurnsWithTheCamera) {
  VelocityPrior prior;
  for (int i = 0; i < 30; ++i) prior.add(step(1, 90), kInterval);
  const Eigen::Vector3d next = prior.next(1, {}).T.translation();
  EXPECT_LT(next.x(), 0) << "it moves on in the world, and has turned to the right";
  EXPECT_NEAR(next.z(), 0, 1e-9);
}

TEST(VelocityPrior, KnowsNoVelocityAfterAnInterruption) {
  VelocityPrior prior;
  for (int i = 0; i < 30; ++i) prior.add(step(1.2), kInterval);
  const double share = prior.keptShare();
  prior.interrupt();
  EXPECT_EQ(prior.next(1, {}).T.matrix(), Eigen::Matrix4d::Identity());
  EXPECT_EQ(prior.keptShare(), share);
  prior.add(step(1.2), kInterval);
  EXPECT_GT(prior.next(1, {}).T.translation().z(), 1);
  EXPECT_EQ(prior.next(5, {}).T.matrix(), Eigen::Matrix4d::Identity()) << "too long ago";
}

}  // namespace
}  // namespace facetloc::internal
