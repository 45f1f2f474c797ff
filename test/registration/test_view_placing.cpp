// SPDX-License-Identifier: BSD-3-Clause
#include "motion/step_prior.h"
#include "motion/view_placing.h"

#include <facetloc/features/pose.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/synthetic_views.h>

#include <gtest/gtest.h>

namespace facetloc {

using namespace internal;
using test::largeRoom, test::lookingAlong, test::PoseNear, test::viewFrom;
namespace {

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
}  // namespace facetloc
