// SPDX-License-Identifier: BSD-3-Clause
#include "motion/view_odometry.h"
#include "nearby/view_alignment.h"
#include "opened_map.h"

#include <facetloc/localization/localizer.h>
#include <facetloc/testing/changed_views.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/random_segments.h>
#include <facetloc/testing/synthetic_views.h>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <random>

namespace facetloc {
namespace {

using test::lookingAlong, test::MatrixNear, test::mounted, test::onCircle, test::PoseNear, test::Rng,
    test::viewFrom, testing::HasSubstr;

constexpr double kFrame = 1.0 / 30;  // [s]

/** Views of a camera in motion, and where it was. */
struct Drive {
  std::vector<Eigen::Isometry3d> truth;
  std::vector<View> views;

  Drive() = default;
  Drive(const test::Scene& scene, std::vector<Eigen::Isometry3d> poses, unsigned seed)
      : truth(std::move(poses)) {
    views.resize(truth.size());
    const int n = static_cast<int>(truth.size());
    for (int i = 0; i < n; ++i) views[i] = viewFrom(scene, truth[i], seed + static_cast<unsigned>(i));
  }
};

std::shared_ptr<Map> mapOf(const test::Scene& scene, const std::vector<Eigen::Isometry3d>& poses) {
  auto map = std::make_shared<Map>();
  const Drive views(scene, poses, 1000);
  for (std::size_t i = 0; i < poses.size(); ++i) map->models.emplace_back("", 0, poses[i], views.views[i]);
  return map;
}

/** A pose of which soon too little is known where views show little. */
GlobalLocalizationParams narrowLimits() {
  GlobalLocalizationParams params;
  params.sure.max_translation = 0.15, params.sure.max_rotation_deg = 3;
  return params;
}

class FilmOfARoom : public testing::Test {
protected:
  static constexpr int kViews = 90;
  static void SetUpTestSuite() {
    std::vector<Eigen::Isometry3d> models, poses;
    for (int i = 0; i < 18; ++i) models.push_back(onCircle(20 * i, 0.35));
    map = test::openedMap(*mapOf(test::largeRoom(), models));
    for (int i = 0; i < kViews; ++i)  // 0.4 m/s and 36 deg/s, with a sway
      poses.push_back(onCircle(10 + 1.2 * i, 0.6, 1.2 + 0.03 * std::sin(0.3 * i)));
    drive = std::make_unique<Drive>(test::largeRoom(), poses, 1);
  }
  static void TearDownTestSuite() { map.reset(), drive.reset(); }

  /** A tracker that has found the first views of the drive; the next one is number next_. */
  Localizer started(const GlobalLocalizationParams& params = {}) {
    Localizer localizer(map, {}, params);
    for (next_ = 0; next_ < 10; ++next_) last_ = localizer.update(drive->views[next_], next_ * kFrame);
    EXPECT_EQ(last_.tracking, TrackingState::tracking) << last_.reason;
    return localizer;
  }
  static double tiltOf(const Eigen::Isometry3d& T_w_c) {
    return -std::asin(T_w_c.linear().col(2).z()) / kDegree;
  }
  static bool isGood(const Localization& pose, const Eigen::Isometry3d& truth) {
    if (!pose.T_w_c) return false;
    const Vector6d e = boxminus(truth, pose.T_w_c->T);
    return e.head<3>().norm() < 1 * kDegree && e.tail<3>().norm() < 0.05;
  }
  static bool isWithinItsError(const PoseWithCovariance& pose, const Eigen::Isometry3d& truth) {
    return boxminus(truth, pose.T).tail<3>().norm() < largestTranslationStd(pose.P);
  }

  static inline std::shared_ptr<Map> map;
  static inline std::unique_ptr<Drive> drive;
  int next_ = 0;
  Localization last_;
};

TEST_F(FilmOfARoom, TheStoreyAboveIsNotTheFloor) {
  auto two_storeys = std::make_shared<Map>(*map);
  const CameraMounting mounting{1.2, tiltOf(onCircle(0, 0.6))};
  two_storeys->camera.mounting = mounting;
  for (LocalModel m : map->models) {  // models of another room
    m.setView(viewFrom(test::furnishedRoom(), lookingAlong({2, 1.5, 1.2}, m.T_w_m->linear().col(2)),
                       static_cast<unsigned>(two_storeys->models.size())));
    m.T_w_m->translation().z() += 3;
    two_storeys->models.push_back(std::move(m));
  }
  Localizer localizer(two_storeys);
  int good = 0;
  for (int i = 0; i < kViews; ++i)
    good += isGood(localizer.update(mounted(drive->views[i], mounting), i * kFrame), drive->truth[i]);
  EXPECT_GE(good, kViews - 3);
}

TEST_F(FilmOfARoom, ViewsThatNoPlaceExplainsAreNoCrash) {
  auto large = std::make_shared<Map>(*map);  // where a place is very likely not one of a few
  for (int i = 0; i < 10000; ++i)
    large->models.emplace_back("", 0, Eigen::Isometry3d(Eigen::Translation3d(100 + i, 0, 1)), View());
  Localizer localizer(large);
  for (int i = 0; i < 10; ++i) {
    const double a = 0.157 * i;
    const View elsewhere = viewFrom(test::furnishedRoom(),
                                    lookingAlong({1.5, 1 + 0.05 * i, 1.3}, {std::sin(a), std::cos(a), -0.2}),
                                    static_cast<unsigned>(i));
    const Localization pose = localizer.update(elsewhere, i * kFrame);
    EXPECT_FALSE(pose.T_w_c);
    EXPECT_NE(pose.reason, "");
  }
}

TEST_F(FilmOfARoom, FollowsTheCameraAndKnowsItsError) {
  Localizer localizer(map);
  double nees = 0, translation = 0;
  for (int i = 0; i < kViews; ++i) {
    const Localization pose = localizer.update(drive->views[i], i * kFrame);
    EXPECT_EQ(pose.tracking, i == 0 ? TrackingState::localized : TrackingState::tracking) << i << pose.reason;
    EXPECT_EQ(pose.reason, "");
    ASSERT_TRUE(pose.T_w_c);
    EXPECT_THAT(pose.T_w_c->T, PoseNear(drive->truth[i], 0.05, 1));
    const Vector6d e = boxminus(drive->truth[i], pose.T_w_c->T);
    nees += e.dot(pose.T_w_c->P.ldlt().solve(e)) / kViews;
    translation += e.tail<3>().norm() / kViews;
  }
  EXPECT_LT(translation, 0.015);
  EXPECT_LT(nees, 9);  // 6 if all errors were independent; no overconfidence but by models in common
  // White noise errs less than assumed, since common errors of neighbours are allowed for, and no less than
  // that.
  constexpr double kCorrelatedViews = 2;  // mapping/METHOD 2
  const double caution = internal::kCorrelatedPixels * kCorrelatedViews *
                         std::pow(internal::DenseRefinementParams{}.pixel_error, 2);
  EXPECT_GT(nees, 6 / caution);
}

TEST_F(FilmOfARoom, FollowsEveryFourthView) {
  Localizer localizer(map);
  for (int i = 0; i < kViews; i += 4) {
    const Localization pose = localizer.update(drive->views[i], i * kFrame);
    if (i == 0) continue;
    EXPECT_TRUE(isGood(pose, drive->truth[i])) << i << ": " << pose.reason;
  }
}

TEST_F(FilmOfARoom, TheMatchedModelIsDrawnAsItIs) {
  started();
  ASSERT_FALSE(last_.hypotheses.empty());
  const Hypothesis& match = last_.hypotheses.front();
  const LocalModel& model = map->models.at(match.model);
  const std::shared_ptr<const View> view = map->view(match.model);
  EXPECT_THAT(*model.T_w_m * match.T_m_c.T, PoseNear(last_.T_w_c->T, 1e-9, 1e-6));
  EXPECT_FALSE(match.pairs.empty());
  for (const SegmentPair& p : match.pairs) {
    ASSERT_LT(static_cast<std::size_t>(p.scene), drive->views[next_ - 1].segments.size());
    ASSERT_LT(static_cast<std::size_t>(p.model), view->segments.size());
    const Eigen::Vector3d n = match.T_m_c.T.linear() * drive->views[next_ - 1].segments[p.scene].normal();
    EXPECT_GT(n.dot(view->segments[p.model].normal()), 0.95);
  }
  // The covariance in model axes is the covariance of draws in world axes.
  Rng rng(1);
  constexpr int kDraws = 20000;
  Matrix6d drawn = Matrix6d::Zero();
  for (int i = 0; i < kDraws; ++i) {
    const Eigen::Isometry3d T_w_c = boxplus(last_.T_w_c->T, test::gaussian<6>(rng, last_.T_w_c->P));
    const Vector6d d = boxminus(model.T_w_m->inverse() * T_w_c, match.T_m_c.T);
    drawn += d * d.transpose() / kDraws;
  }
  EXPECT_THAT(drawn, MatrixNear(match.T_m_c.P, 0.05 * match.T_m_c.P.diagonal().maxCoeff()));
}

TEST_F(FilmOfARoom, AKidnappingIsNoticedAndRepaired) {
  Localizer localizer = started();
  const int jump = 60;
  int noticed = -1, found = -1;
  for (int i = jump; i < kViews && found < 0; ++i, ++next_) {
    const Localization pose = localizer.update(drive->views[i], next_ * kFrame);
    if (noticed < 0 && (pose.tracking == TrackingState::lost || pose.tracking == TrackingState::localized))
      noticed = i;
    if (pose.tracking == TrackingState::tracking) {
      EXPECT_GE(noticed, 0) << "tracks on as if nothing had happened";
      EXPECT_TRUE(isGood(pose, drive->truth[i]));
    }
    if (pose.tracking == TrackingState::localized) {
      EXPECT_TRUE(isGood(pose, drive->truth[i]));
      found = i;
    }
  }
  EXPECT_GE(noticed, jump);
  EXPECT_LE(noticed, jump + 4);
  EXPECT_GE(found, noticed);
  EXPECT_LE(found, noticed + 4);
}

TEST_F(FilmOfARoom, APlaceThatTheNextViewContradictsIsForgotten) {
  Localizer localizer(map);
  EXPECT_TRUE(isGood(localizer.update(drive->views[0], 0), drive->truth[0]));
  const Localization second = localizer.update(drive->views[70], kFrame);
  EXPECT_TRUE(second.began_anew);
  EXPECT_EQ(second.tracking, TrackingState::localized);
  EXPECT_TRUE(isGood(second, drive->truth[70]));
  const Localization third = localizer.update(drive->views[71], 2 * kFrame);
  EXPECT_EQ(third.tracking, TrackingState::tracking);
  EXPECT_TRUE(isGood(third, drive->truth[71]));
}

TEST_F(FilmOfARoom, EmptyViewsAreBridgedForAWhile) {
  Localizer localizer = started(narrowLimits());
  View empty;
  empty.intrinsics = drive->views[0].intrinsics;
  double std = 0;
  for (int i = 0; i < 4; ++i, ++next_) {
    const Localization pose = localizer.update(empty, next_ * kFrame);
    if (i > 1) {  // until then it knows well enough how it moves
      EXPECT_EQ(pose.tracking, TrackingState::degenerate);
      EXPECT_THAT(pose.reason, HasSubstr("no planar segment"));
    }
    ASSERT_TRUE(pose.T_w_c);
    EXPECT_GT(pose.T_w_c->P.trace(), std);
    std = pose.T_w_c->P.trace();
  }
  const Localization pose = localizer.update(drive->views[next_], next_ * kFrame);
  EXPECT_EQ(pose.tracking, TrackingState::tracking) << pose.reason;
  EXPECT_TRUE(isGood(pose, drive->truth[next_]));
}

TEST_F(FilmOfARoom, ARobotOnWheelsIsKeptOnItsFloorInTheDark) {
  double height[2] = {0, 0};  // std [m]: as it likes, on wheels
  for (const bool on_wheels : {false, true}) {
    auto floor = std::make_shared<Map>(*map);
    const CameraMounting mounting{1.2, tiltOf(drive->truth[0])};
    if (on_wheels) floor->camera.mounting = mounting;
    const auto seen = [&](const View& view) { return on_wheels ? mounted(view, mounting) : view; };
    Localizer localizer(floor);
    for (next_ = 0; next_ < 10; ++next_) last_ = localizer.update(seen(drive->views[next_]), next_ * kFrame);
    for (; next_ < 16; ++next_) last_ = localizer.update(seen({}), next_ * kFrame);
    ASSERT_TRUE(last_.T_w_c) << last_.reason;
    EXPECT_NEAR(last_.T_w_c->T.translation().z(), 1.2, 0.05);
    height[on_wheels] = std::sqrt(last_.T_w_c->P(5, 5));
  }
  EXPECT_LT(height[1], 0.3 * height[0]);
}

TEST_F(FilmOfARoom, ARobotThatGoesSidewaysIsBelieved) {
  // It circles about the middle and looks outwards, on wheels that can do so.
  auto floor = std::make_shared<Map>(*map);
  const CameraMounting mounting{1.2, tiltOf(drive->truth[0])};
  floor->camera.mounting = mounting;
  Localizer localizer(floor);
  for (int i = 0; i < kViews; ++i) {
    const Localization pose = localizer.update(mounted(drive->views[i], mounting), i * kFrame);
    // Three planes leave a direction open for thirty views on end; there it knows its uncertainty.
    const bool is_open = pose.T_w_c && largestTranslationStd(pose.T_w_c->P) > 0.05;
    EXPECT_TRUE(i == 0 || (is_open && isWithinItsError(*pose.T_w_c, drive->truth[i])) ||
                isGood(pose, drive->truth[i]))
        << i << ": " << pose.reason;
  }
}

TEST_F(FilmOfARoom, AfterADarkWhileItIsLostAndFindsItselfAgain) {
  Localizer localizer = started();
  Localization pose;
  double stamp = next_ * kFrame;
  for (int i = 0; i < 300; ++i) pose = localizer.update(View(), stamp += kFrame);
  EXPECT_EQ(pose.tracking, TrackingState::lost);
  EXPECT_FALSE(pose.T_w_c);
  int i = 50;  // it is as new as a kidnapping: somewhere else than it would be by its last velocity
  for (; i < 65 && pose.tracking != TrackingState::localized; ++i) {
    pose = localizer.update(drive->views[i], stamp += kFrame);
    EXPECT_TRUE(!pose.T_w_c || isGood(pose, drive->truth[i])) << i;
  }
  EXPECT_EQ(pose.tracking, TrackingState::localized) << pose.reason;
}

// Wheels that run 1 % too far.
PoseWithCovariance byWheels(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to) {
  Eigen::Isometry3d motion = from.inverse() * to;
  motion.translation() *= 1.01;
  return motionByOdometry(motion, {});
}

TEST_F(FilmOfARoom, AnOdometryCarriesItThroughTheDark) {
  double std[2] = {0, 0};  // without it and with it [m]
  for (const bool has_odometry : {false, true}) {
    Localizer localizer = started();
    Localization pose;
    for (int last = 60; next_ < last; ++next_) {
      std::optional<PoseWithCovariance> motion;
      if (has_odometry) motion = byWheels(drive->truth[next_ - 1], drive->truth[next_]);
      pose = localizer.update(View(), next_ * kFrame, motion);
    }
    ASSERT_TRUE(pose.T_w_c) << pose.reason;
    std[has_odometry] = largestTranslationStd(pose.T_w_c->P);
    if (!has_odometry) continue;
    EXPECT_EQ(pose.tracking, TrackingState::tracking) << pose.reason;
    EXPECT_THAT(pose.T_w_c->T, PoseNear(drive->truth[next_ - 1], 0.05, 1));
    EXPECT_TRUE(isWithinItsError(*pose.T_w_c, drive->truth[next_ - 1]));
    pose = localizer.update(drive->views[next_], next_ * kFrame,
                            byWheels(drive->truth[next_ - 1], drive->truth[next_]));
    EXPECT_EQ(pose.tracking, TrackingState::tracking) << pose.reason;
    EXPECT_TRUE(isGood(pose, drive->truth[next_]));
  }
  EXPECT_LT(std[1], 0.5 * std[0]);
}

TEST_F(FilmOfARoom, AnOdometryBridgesAnyGap) {
  for (const bool has_odometry : {false, true}) {
    Localizer localizer = started();
    std::optional<PoseWithCovariance> motion;
    if (has_odometry) motion = byWheels(drive->truth[next_ - 1], drive->truth[70]);
    const Localization pose = localizer.update(drive->views[70], next_ * kFrame + 20, motion);
    EXPECT_EQ(pose.began_anew, !has_odometry);
    EXPECT_EQ(pose.tracking, has_odometry ? TrackingState::tracking : TrackingState::localized)
        << pose.reason;
    EXPECT_TRUE(!has_odometry || isGood(pose, drive->truth[70]));
  }
}

TEST_F(FilmOfARoom, AnOdometryThatKnowsNothingOfAKidnappingIsNotBelieved) {
  Localizer localizer = started();
  int found = -1;
  for (int i = 60; i < kViews && found < 0; ++i, ++next_) {
    const Localization pose =
        localizer.update(drive->views[i], next_ * kFrame, byWheels(drive->truth[i - 1], drive->truth[i]));
    if (pose.tracking == TrackingState::localized) {
      EXPECT_TRUE(isGood(pose, drive->truth[i]));
      found = i;
    }
  }
  EXPECT_GE(found, 60);
}

TEST_F(FilmOfARoom, AnOdometryOfNaNsIsIgnored) {
  Localizer localizer = started();
  PoseWithCovariance nan = byWheels(Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity());
  nan.T.translation().x() = std::numeric_limits<double>::quiet_NaN();
  const Localization pose = localizer.update(drive->views[next_], next_ * kFrame, nan);
  EXPECT_EQ(pose.tracking, TrackingState::tracking);
  EXPECT_TRUE(isGood(pose, drive->truth[next_]));
  EXPECT_TRUE(localizer.update(drive->views[70], next_ * kFrame + 20, nan).began_anew) << "it bridges no gap";
}

TEST_F(FilmOfARoom, StampsThatGoBackOrFarAheadStartAnew) {
  for (const double stamp : {-5.0, 60.0, std::numeric_limits<double>::quiet_NaN()}) {
    Localizer localizer = started();
    Localization pose = localizer.update(drive->views[40], stamp);
    EXPECT_TRUE(pose.began_anew) << stamp;
    EXPECT_TRUE(stamp > 0 || pose.looks == 1) << stamp;
    EXPECT_TRUE(pose.state != AnswerState::sure || isNear(pose.T_w_c->T, drive->truth[40], 0.3, 5)) << stamp;
    EXPECT_NE(pose.reason, "");
    const double next = std::isnan(stamp) ? 0 : stamp;
    localizer.update(drive->views[40], next);
    pose = localizer.update(drive->views[41], next + kFrame);
    EXPECT_TRUE(isGood(pose, drive->truth[41])) << stamp << ": " << pose.reason;
  }
}

TEST_F(FilmOfARoom, TheSameViewTwiceChangesLittle) {
  Localizer localizer = started();
  const double stamp = (next_ - 1) * kFrame;
  const Localization again = localizer.update(drive->views[next_ - 1], stamp);
  EXPECT_EQ(again.tracking, TrackingState::tracking);
  EXPECT_THAT(again.T_w_c->T, PoseNear(last_.T_w_c->T, 0.01, 0.2));
}

TEST_F(FilmOfARoom, RelocalizeForgets) {
  Localizer localizer = started();
  localizer.reset();
  const Localization pose = localizer.update(drive->views[next_], next_ * kFrame);
  EXPECT_EQ(pose.tracking, TrackingState::localized);
  EXPECT_EQ(pose.looks, 1);
}

TEST_F(FilmOfARoom, AMapWithoutWorldPosesSaysSo) {
  auto bare = std::make_shared<Map>(*map);
  for (LocalModel& m : bare->models) m.T_w_m.reset();
  const Localization pose = Localizer(bare).update(drive->views[0], 0);
  EXPECT_EQ(pose.tracking, TrackingState::searching);
  EXPECT_THAT(pose.reason, HasSubstr("no local model"));
  const Localization of_nothing = Localizer(std::make_shared<Map>()).update(drive->views[0], 0);
  EXPECT_EQ(of_nothing.tracking, TrackingState::searching);
  for (const Localization& answer : {pose, of_nothing}) EXPECT_EQ(answer.state, AnswerState::unknown);
  EXPECT_NE(of_nothing.reason, "");
}

TEST_F(FilmOfARoom, WithoutDepthPicturesThePlanesFollow) {
  auto bare = std::make_shared<Map>(*map);
  test::changeViews(*bare, [](View& view) { view.depth = {}; });
  Localizer localizer(bare);
  localizer.setMinProbability(0.3);  // there is less evidence
  int good = 0;
  for (int i = 0; i < 30; ++i) {
    View view = drive->views[i];
    view.depth = {};
    good += isGood(localizer.update(view, i * kFrame), drive->truth[i]);
  }
  EXPECT_GE(good, 20);
}

/** A corridor along y that begins with a wall and a cupboard, and then has nothing but its walls. */
class FilmOfACorridor : public testing::Test {
protected:
  static test::Scene corridor() {
    test::Scene scene = test::box({-0.9, 0, 0}, {0.9, 120, 2.4});
    return scene + test::box({0.3, 0.6, 0}, {0.9, 1.4, 1.3}) + test::box({-0.9, 0.2, 0}, {-0.5, 0.9, 1.7});
  }
};

TEST_F(FilmOfACorridor, ThePositionAlongItIsDegenerate) {
  std::vector<Eigen::Isometry3d> poses, models;
  const auto at = [](double y) { return lookingAlong({0.05, y, 1.2}, {0.03, 1, -0.12}); };
  const auto turned = [](double degrees) {
    const double a = degrees * kDegree;
    return lookingAlong({0.05, 2.5, 1.2}, {std::sin(a), -std::cos(a), -0.12});
  };
  constexpr std::size_t kTurned = 76;        // views; in the middle of the turn a side wall fills the picture
  for (std::size_t i = 0; i < kTurned; ++i)  // turn between the wall and the open end, 72 deg/s
    poses.push_back(turned(2.4 * static_cast<double>(i)));
  // Then to and fro, as the motion model assumes: no view could reveal a steady motion either.
  Rng rng(4);
  std::normal_distribution<double> step(0, internal::kSpeedChange * kFrame);
  double y = 2.5;
  for (int i = 1; i <= 60; ++i) poses.push_back(at(y += step(rng)));
  for (int i = 0; i <= 12; ++i) models.push_back(turned(15 * i));
  for (int i = 1; i < 5; ++i) models.push_back(at(2.5 + 0.5 * i));
  const auto map = mapOf(corridor(), models);
  const Drive drive(corridor(), poses, 1);

  Localizer localizer(map, {}, narrowLimits());
  int told = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Localization pose = localizer.update(drive.views[i], static_cast<double>(i) * kFrame);
    if (i < 2) continue;
    ASSERT_TRUE(pose.T_w_c) << i << ": " << pose.reason;
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> shift(pose.T_w_c->P.bottomRightCorner<3, 3>());
    const Vector6d e = boxminus(poses[i], pose.T_w_c->T);
    EXPECT_LT(e.head<3>().norm(), 1 * kDegree) << i;
    EXPECT_LT(std::hypot(e[3], e[5]), 0.03) << i;
    EXPECT_LT(std::abs(e[4]), 4 * std::sqrt(pose.T_w_c->P(4, 4))) << i;
    if (pose.tracking != TrackingState::degenerate || i < kTurned) continue;
    ++told;
    EXPECT_THAT(pose.reason, HasSubstr("translation along"));
    EXPECT_THAT(pose.reason, testing::Not(HasSubstr("rotation")));
    EXPECT_GT(std::abs(shift.eigenvectors().col(2).y()), 0.95) << i;
    EXPECT_LT(std::sqrt(shift.eigenvalues()[1]), 0.05) << i;
  }
  EXPECT_GE(told, 20);
}

}  // namespace
}  // namespace facetloc
