// SPDX-License-Identifier: BSD-3-Clause
#include "motion/view_odometry.h"

#include <facetloc/features/camera_model.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/synthetic_views.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace facetloc {
namespace {

using namespace internal;
using test::largeRoom, test::lookingAlong, test::mounted, test::PoseNear, test::viewFrom;

constexpr double kPi = 180 * kDegree;
constexpr double kStep = 1.0 / 15;  // [s]

ViewOdometry odometry() {
  ViewAlignmentParams alignment;
  alignment.dense.correlated_pixels = 200, alignment.dense.significance = 4;
  return ViewOdometry({}, alignment);
}

/** Around the middle of the room: 0.4 m/s and 30 deg/s. */
Eigen::Isometry3d onCircle(int i) { return test::onCircle(2 * i, 0.75, 1.2, 0.25); }

TEST(ViewOdometry, FollowsTheCameraWithoutAMap) {
  ViewOdometry camera = odometry();
  constexpr int kViews = 40;
  Eigen::Isometry3d way = Eigen::Isometry3d::Identity();
  for (int i = 0; i < kViews; ++i) {
    const ViewMotion motion = camera.add(viewFrom(largeRoom(), onCircle(i), 50 + i), kStep);
    EXPECT_FALSE(motion.broken) << i;
    way = way * motion.T_a_b.T;
    if (i == 0) {
      EXPECT_THAT(motion.T_a_b.T, PoseNear(Eigen::Isometry3d::Identity(), 1e-12, 1e-9));
      continue;
    }
    EXPECT_GT(motion.agreement, 0.9) << i;
    EXPECT_THAT(motion.T_a_b.T, PoseNear(onCircle(i - 1).inverse() * onCircle(i), 0.02, 0.5)) << i;
  }
  // 1 m and 78 deg later
  EXPECT_THAT(way, PoseNear(onCircle(0).inverse() * onCircle(kViews - 1), 0.04, 1.0));
}

TEST(ViewOdometry, NoticesAJumpAndGoesOnFromThere) {
  ViewOdometry camera = odometry();
  for (int i = 0; i < 5; ++i)
    EXPECT_FALSE(camera.add(viewFrom(largeRoom(), onCircle(i), 50 + i), kStep).broken);
  EXPECT_TRUE(camera.add(viewFrom(largeRoom(), onCircle(22), 3), kStep).broken);
  const ViewMotion next = camera.add(viewFrom(largeRoom(), onCircle(23), 4), kStep);
  EXPECT_FALSE(next.broken);
  EXPECT_THAT(next.T_a_b.T, PoseNear(onCircle(22).inverse() * onCircle(23), 0.02, 0.5));
}

TEST(ViewOdometry, WithUninformativeViewsItKeepsItsVelocityAndSaysSo) {
  // Along a corridor with one cupboard, past it.
  const test::Scene corridor = test::endlessCorridor() + test::box({0.4, 1.5, 0}, {0.9, 2.0, 1.5});
  const auto at = [](int i) { return lookingAlong({0, 0.5 * kStep * i, 1.2}, {0.05, 1, -0.2}); };
  ViewOdometry camera = odometry();
  constexpr int kViews = 60;
  Eigen::Isometry3d way = at(0);
  ViewMotion motion;
  for (int i = 0; i < kViews; ++i) {
    motion = camera.add(viewFrom(corridor, at(i), 70 + i, 5), kStep);
    way = way * motion.T_a_b.T;
  }
  EXPECT_FALSE(motion.broken);
  // The cupboard leaves the picture at 1.3 m: a camera that believed the bare walls would stop there, 0.7 m
  // too early.
  EXPECT_NEAR(way.translation().y(), at(kViews - 1).translation().y(), 0.35);
  EXPECT_NEAR(way.translation().x(), 0, 0.03);
  const Eigen::Vector3d along = at(0).linear().transpose() * Eigen::Vector3d::UnitY();
  EXPECT_GT(along.dot(motion.T_a_b.P.bottomRightCorner<3, 3>() * along), std::pow(0.01, 2));
}

TEST(ViewOdometry, ARobotOnWheelsKnowsThatItDoesNotSlipAlongABareWall) {
  // Drives towards a cupboard in an endless corridor and turns to the wall on the spot, which shows nothing
  // of where along the corridor it is.
  const test::Scene corridor = test::endlessCorridor() + test::box({0.4, 2.5, 0}, {0.9, 3.0, 1.5});
  constexpr int kDriving = 30, kTurning = 30, kWaiting = 15;
  const auto at = [&](int i) {
    const double a = kPi / 2 * std::clamp((i - kDriving) / double(kTurning), 0.0, 1.0);
    return lookingAlong({0, 0.5 * kStep * std::min(i, kDriving), 1.2}, {std::sin(a), std::cos(a), 0});
  };
  double std[2] = {0, 0};  // standard deviation of a step along the wall: free, on wheels [m]
  for (const bool on_wheels : {false, true}) {
    ViewOdometry camera = odometry();
    Eigen::Isometry3d way = at(0);
    ViewMotion motion;
    for (int i = 0; i < kDriving + kTurning + kWaiting; ++i) {
      View view = viewFrom(corridor, at(i), 70 + i, 5);
      if (on_wheels) view = mounted(std::move(view), CameraMounting{1.2, 0});
      motion = camera.add(view, kStep);
      EXPECT_FALSE(motion.broken) << i;
      way = way * motion.T_a_b.T;
    }
    EXPECT_NEAR(way.translation().y(), at(kDriving).translation().y(), 0.03);
    std[on_wheels] = std::sqrt(motion.T_a_b.P(3, 3));
  }
  EXPECT_LT(std[1], 0.6 * std[0]);
}

// Variance of the distance [m^2] through a part of the circle, or without moving, by this number of views.
double varianceOfPosition(int views, double degrees) {
  ViewOdometry camera = odometry();
  double sum = 0;
  for (int i = 0; i <= views; ++i) {
    const Eigen::Isometry3d T = test::onCircle(degrees * i / views, 0.75, 1.2, 0.25);
    const ViewMotion motion = camera.add(viewFrom(largeRoom(), T, 50 + i), kStep);
    EXPECT_FALSE(motion.broken) << i;
    if (i > 0) sum += motion.T_a_b.P.bottomRightCorner<3, 3>().trace();
  }
  return sum;
}

TEST(ViewOdometry, ErrorsAgainstAKeyframeAddUpByTheDistanceNotByTheNumberOfViews) {
  const double few = varianceOfPosition(16, 40), many = varianceOfPosition(48, 40),
               standing = varianceOfPosition(48, 0);
  EXPECT_LT(many, 1.5 * few);
  EXPECT_GT(many, 0.5 * few);
  EXPECT_LT(standing, 0.7 * many);  // the rest comes from the prediction, which assumes motion
}

TEST(ViewOdometry, ResetForgetsEverything) {
  const CameraMounting mounting{1.2, std::atan(0.25) / kDegree};
  ViewOdometry used = odometry(), fresh = odometry();
  for (int i = 0; i < 10; ++i)  // sideways
    used.add(mounted(viewFrom(largeRoom(), onCircle(i), 50 + i), mounting), kStep);
  used.reset();
  for (int i = 0; i < 4; ++i) {
    const View view = mounted(i < 3 ? viewFrom(largeRoom(), onCircle(20), 90 + i) : View(), mounting);
    const ViewMotion a = used.add(view, kStep), b = fresh.add(view, kStep);
    EXPECT_EQ(a.T_a_b.T.matrix(), b.T_a_b.T.matrix()) << i;
    EXPECT_EQ(a.T_a_b.P, b.T_a_b.P) << i;
  }
}

TEST(ViewOdometry, AnEmptyViewIsNoObstacle) {
  ViewOdometry camera = odometry();
  EXPECT_FALSE(camera.add({}, 0).broken);
  for (int i = 0; i < 6; ++i) camera.add(viewFrom(largeRoom(), onCircle(i), 50 + i), kStep);
  EXPECT_FALSE(camera.add({}, kStep).broken);
  const ViewMotion motion = camera.add(viewFrom(largeRoom(), onCircle(7), 9), kStep);
  EXPECT_FALSE(motion.broken);
  EXPECT_GT(motion.agreement, 0.9);
}

}  // namespace
}  // namespace facetloc
