// SPDX-License-Identifier: BSD-3-Clause
#include "motion/step_prior.h"
#include "motion/view_placing.h"

#include <facetloc/features/pose.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/synthetic_views.h>

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

using test::largeRoom, test::lookingAlong, test::PoseNear, test::viewFrom;

PoseWithCovariance anywhere(const Eigen::Isometry3d& T = Eigen::Isometry3d::Identity()) {
  return {T, stepCovariance({}, true)};
}

TEST(ViewPlacing, FindsTheMotionFromAFarStart) {
  const Eigen::Isometry3d a = lookingAlong({2.5, 2, 1.2}, {1, 0.6, -0.25}),
                          b = lookingAlong({2.8, 2.2, 1.2}, {0.9, 0.95, -0.25});
  const View of_a = viewFrom(largeRoom(), a, 1), of_b = viewFrom(largeRoom(), b, 2);
  const ViewPlacing placing;
  const auto found = placing.place(of_b, of_a, anywhere(), true);
  ASSERT_TRUE(found);
  EXPECT_THAT(found->T_a_b, PoseNear(a.inverse() * b, 0.02, 0.4));
  EXPECT_GT(found->agreement, 0.95);
  EXPECT_GT(found->overlap, 0.4);
  const Vector6d off = boxminus(found->T_a_b, a.inverse() * b);
  EXPECT_LT(off.dot(found->information * off), chiSquareQuantile(6, 0.999)) << "beyond the 99.9 % ellipsoid";
}

TEST(ViewPlacing, WhereNothingIsInCommonNothingAgrees) {
  const View there = viewFrom(largeRoom(), lookingAlong({3, 2.5, 1.2}, {1, 0.3, -0.2}), 1),
             elsewhere = viewFrom(test::endlessCorridor(), lookingAlong({0, 0, 1.2}, {0, 1, -0.2}), 2, 5);
  const auto found = ViewPlacing().place(elsewhere, there, anywhere(), true);
  EXPECT_TRUE(!found || found->agreement < 0.8 || found->overlap < 0.2);
}

TEST(ViewPlacing, TwoViewsAlongACorridorAreDegenerate) {
  const auto at = [](double y) { return lookingAlong({0, y, 1.2}, {0, 1, -0.2}); };
  const View a = viewFrom(test::endlessCorridor(), at(0), 1, 5),
             b = viewFrom(test::endlessCorridor(), at(0.2), 2, 5);
  const auto found = ViewPlacing().place(b, a, anywhere(), false);
  ASSERT_TRUE(found);
  Vector6d ahead = Vector6d::Zero();
  ahead.tail<3>() = at(0).linear().transpose() * Eigen::Vector3d::UnitY();
  const Matrix6d P = symmetricInverse(found->information + 1e-4 * Matrix6d::Identity());
  EXPECT_GT(std::sqrt(ahead.dot(P * ahead)), 0.2);
  Vector6d sideways = Vector6d::Zero();
  sideways.tail<3>() = at(0).linear().transpose() * Eigen::Vector3d::UnitX();
  EXPECT_LT(std::sqrt(sideways.dot(P * sideways)), 0.1);
}

TEST(ViewPlacing, ViewsWithoutDepthAreNowhere) {
  EXPECT_FALSE(ViewPlacing().place({}, {}, anywhere(), true));
}

TEST(StepPrior, ARobotHardlyMovesSidewaysUnlessItSlides) {
  const CameraMounting mounting{1, 20};
  const Matrix6d rolls = stepCovariance(mounting, false), slides = stepCovariance(mounting, true);
  EXPECT_EQ(Eigen::LLT<Matrix6d>(rolls).info(), Eigen::Success);
  const auto std = [](const Matrix6d& P, int axis) { return std::sqrt(P(3 + axis, 3 + axis)); };
  EXPECT_LT(std(rolls, 0), 0.1);  // right of the camera
  EXPECT_GT(std(slides, 0), 0.35);
  EXPECT_GT(std(rolls, 2), 0.3);  // ahead of it
  EXPECT_EQ(stepCovariance({}, false), stepCovariance({}, true)) << "in the hand";
}

TEST(StepPrior, MeasuresTheSidewaysShiftOfARobot) {
  const CameraMounting mounting{1, 20};
  const Eigen::Isometry3d base(Eigen::Translation3d(0.3, 0.07, 0));
  const Eigen::Isometry3d T_b_c = mounting.T_b_c();
  const SidewaysShift s =
      sidewaysShift({T_b_c.inverse() * base * T_b_c, 1e-4 * Matrix6d::Identity()}, mounting);
  EXPECT_NEAR(s.shift, 0.07, 1e-9);
  EXPECT_NEAR(s.variance, 2e-4, 1.1e-4);
}

}  // namespace
}  // namespace facetloc::internal
