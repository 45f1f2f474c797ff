// SPDX-License-Identifier: BSD-3-Clause
#include "motion/camera_motion.h"
#include "motion/step_prior.h"

#include <facetloc/features/pose.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/synthetic_views.h>

#include <gtest/gtest.h>

#include <memory>
#include <utility>

namespace facetloc {

using namespace internal;
using test::alongCorridor, test::corridorWithNiches, test::endlessCorridor, test::largeRoom,
    test::lookingAlong, test::PoseNear, test::viewFrom;
namespace {

constexpr double kDoorDistance = 1.8;  // distance of the niches [m]

std::shared_ptr<const View> shared(View view) { return std::make_shared<const View>(std::move(view)); }

std::shared_ptr<const View> inRoom(const Eigen::Isometry3d& T, unsigned seed) {
  return shared(viewFrom(largeRoom(), T, seed));
}

/** The motion between two views a second apart. */
Motion motionBetween(const std::shared_ptr<const View>& a, const std::shared_ptr<const View>& b, double dt,
                     const std::optional<PoseWithCovariance>& given = {}) {
  CameraMotion camera{ViewOdometryParams{}};
  camera.next(a, 0);
  return camera.next(b, dt, given);
}

TEST(CameraMotion, ARoomHasOneAnswer) {
  const Eigen::Isometry3d a = lookingAlong({2.5, 2, 1.2}, {1, 0.6, -0.25}),
                          b = lookingAlong({2.9, 2.2, 1.2}, {0.9, 0.95, -0.25});
  const Motion motion = motionBetween(inRoom(a, 1), inRoom(b, 2), 1);
  EXPECT_EQ(motion.source, Motion::Source::seen);
  ASSERT_EQ(motion.modes.size(), 1u);
  EXPECT_DOUBLE_EQ(motion.modes.front().probability, 1);
  EXPECT_GT(motion.agreement, 0.9);
  EXPECT_THAT(motion.likeliest().T, PoseNear(a.inverse() * b, 0.03, 0.6));
  EXPECT_LT(squaredMahalanobis(motion.likeliest(), a.inverse() * b), chiSquareQuantile(6, 0.999));
}

TEST(CameraMotion, AmongEqualDoorsThereAreSeveral) {
  const auto at = [](double y, unsigned seed) {
    return shared(viewFrom(corridorWithNiches(), alongCorridor(y), seed, 6));
  };
  const Eigen::Isometry3d truth = alongCorridor(0).inverse() * alongCorridor(0.8);
  const Motion motion = motionBetween(at(0, 1), at(0.8, 2), 2);
  EXPECT_EQ(motion.source, Motion::Source::seen);
  ASSERT_GE(motion.modes.size(), 2u);
  double sum = 0, right = 0, one_door_back = 0;
  for (const MotionMode& mode : motion.modes) {
    sum += mode.probability;
    const double ahead = (alongCorridor(0) * mode.T_a_b.T).translation().y();
    if (isNear(mode.T_a_b.T, truth, 0.1, 2)) right += mode.probability;
    if (std::abs(ahead - 0.8 + kDoorDistance) < 0.1) one_door_back += mode.probability;
  }
  EXPECT_NEAR(sum, 1, 1e-9);
  EXPECT_GT(right, 0.1);
  EXPECT_GT(one_door_back, 0.1);
}

TEST(CameraMotion, AnOdometryChoosesAmongThem) {
  const auto at = [](double y, unsigned seed) {
    return shared(viewFrom(corridorWithNiches(), alongCorridor(y), seed, 6));
  };
  const Eigen::Isometry3d truth = alongCorridor(0).inverse() * alongCorridor(0.8);
  const Motion motion =
      motionBetween(at(0, 1), at(0.8, 2), 2, PoseWithCovariance{truth, 1e-3 * Matrix6d::Identity()});
  EXPECT_THAT(motion.likeliest().T, PoseNear(truth, 0.05, 1));
}

TEST(CameraMotion, AlongABareCorridorOneIsWide) {
  const auto at = [](double y, unsigned seed) {
    return shared(viewFrom(endlessCorridor(), alongCorridor(y), seed, 5));
  };
  const Motion motion = motionBetween(at(0, 1), at(0.5, 2), 1);
  Vector6d ahead = Vector6d::Zero();
  ahead.tail<3>() = alongCorridor(0).linear().transpose() * Eigen::Vector3d::UnitY();
  const Matrix6d prior = motionPrior(1, {});
  EXPECT_GT(ahead.dot(motion.likeliest().P * ahead), 0.25 * ahead.dot(prior * ahead));
  EXPECT_LT(squaredMahalanobis(motion.likeliest(), alongCorridor(0).inverse() * alongCorridor(0.5)),
            chiSquareQuantile(6, 0.99));
}

TEST(CameraMotion, WhereNothingIsInCommonItIsBroken) {
  const auto elsewhere = shared(viewFrom(endlessCorridor(), alongCorridor(0), 2, 5));
  EXPECT_EQ(motionBetween(inRoom(lookingAlong({3, 2.5, 1.2}, {1, 0.3, -0.2}), 1), elsewhere, 1).source,
            Motion::Source::broken);
  const PoseWithCovariance given{Eigen::Isometry3d::Identity(), 1e-4 * Matrix6d::Identity()};
  const Motion carried =
      motionBetween(inRoom(lookingAlong({3, 2.5, 1.2}, {1, 0.3, -0.2}), 1), elsewhere, 1, given);
  EXPECT_NE(carried.source, Motion::Source::broken) << "the odometry may be right";
}

TEST(CameraMotion, ResetForgetsEverything) {
  const Eigen::Isometry3d a = lookingAlong({2.5, 2, 1.2}, {1, 0.6, -0.25}),
                          b = lookingAlong({2.6, 2, 1.2}, {1, 0.65, -0.25});
  CameraMotion used{ViewOdometryParams{}}, fresh{ViewOdometryParams{}};
  used.next(inRoom(b, 3), 0);
  used.reset();
  for (CameraMotion* camera : {&used, &fresh}) camera->next(inRoom(a, 1), 0);
  EXPECT_EQ(used.next(inRoom(b, 2), 0.5).likeliest().T.matrix(),
            fresh.next(inRoom(b, 2), 0.5).likeliest().T.matrix());
}

TEST(MotionPrior, ReachesAsFarAsTheTimeAllows) {
  const auto translation = [](double dt) { return largestTranslationStd(motionPrior(dt, {})); };
  EXPECT_NEAR(translation(2), 2 * translation(1), 1e-9);
  EXPECT_GT(translation(0), 0.1) << "positive definite, and as far as an arm in no time";
  EXPECT_DOUBLE_EQ(translation(3), translation(1e9)) << "bounded";
}

}  // namespace
}  // namespace facetloc
