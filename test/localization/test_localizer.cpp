// SPDX-License-Identifier: BSD-3-Clause
#include "belief/place_belief.h"
#include "opened_map.h"
#include "ranking/global_localization.h"

#include <facetloc/localization/localizer.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/synthetic_views.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace facetloc {
namespace {

using namespace internal;
using test::lookingAlong, test::onCircle, test::viewFrom, testing::HasSubstr;

constexpr double kFrame = 0.1;  // [s]

LocalModel modelAt(const test::Scene& scene, const Eigen::Isometry3d& T_w_m, unsigned seed) {
  return {"", 0, T_w_m, viewFrom(scene, T_w_m, seed)};
}

bool isNearTo(const Localization& answer, const Eigen::Isometry3d& truth, double translation,
              double rotation_deg) {
  return !answer.hypotheses.empty() &&
         isNear(*answer.hypotheses.front().T_w_c, truth, translation, rotation_deg);
}

bool isSureAndWrong(const Localization& answer, const Eigen::Isometry3d& truth) {
  return answer.state == AnswerState::sure && !isNearTo(answer, truth, 0.3, 5);
}

class SequenceInARoom : public testing::Test {
protected:
  static constexpr int kViews = 60;
  static void SetUpTestSuite() {
    map = std::make_shared<Map>();
    for (int i = 0; i < 18; ++i)
      map->models.push_back(modelAt(test::largeRoom(), onCircle(20 * i, 0.35), 1000 + i));
    map = test::openedMap(*map);
    for (int i = 0; i < kViews; ++i) {  // 36 deg/s and, on the circle, 0.4 m/s
      truth.push_back(onCircle(10 + 3.6 * i, 0.6));
      views.push_back(viewFrom(test::largeRoom(), truth.back(), 1 + i));
    }
  }
  static void TearDownTestSuite() { map.reset(), truth.clear(), views.clear(); }

  /** Exact odometry since the view before. */
  static PoseWithCovariance motionTo(int i) {
    return {truth[i - 1].inverse() * truth[i], 1e-6 * Matrix6d::Identity()};
  }
  static inline std::shared_ptr<Map> map;
  static inline std::vector<Eigen::Isometry3d> truth;
  static inline std::vector<View> views;
};

TEST_F(SequenceInARoom, ACameraThatMovesKnowsWhereItIs) {
  Localizer sequence(map);
  int sure = 0, searched = 0;
  for (int i = 0; i < kViews; ++i) {
    const Localization answer = sequence.update(views[i], i * kFrame);
    double sum = answer.not_in_map.value();
    for (const Hypothesis& h : answer.hypotheses) sum += h.probability;
    EXPECT_NEAR(sum, 1, 1e-9);
    EXPECT_FALSE(isSureAndWrong(answer, truth[i])) << i;
    EXPECT_EQ(answer.reason.empty(), answer.state == AnswerState::sure);
    EXPECT_FALSE(answer.began_anew) << i;
    EXPECT_TRUE(i < 20 || isNearTo(answer, truth[i], 0.1, 2)) << i;
    sure += answer.state == AnswerState::sure;
    searched += answer.searched;
  }
  EXPECT_GE(sure, kViews - 20);
  EXPECT_LE(searched, 20);
}

/** The share of the measured pixels of a view that are nearer than in another one from the same place. */
double nearerShare(const View& view, const View& other) {
  int nearer = 0, measured = 0;
  for (std::size_t i = 0; i < view.depth.inverse_depth.size(); ++i) {
    measured += view.depth.inverse_depth[i] > 0;
    nearer += view.depth.inverse_depth[i] > 1.1 * other.depth.inverse_depth[i];
  }
  return nearer / double(measured);
}

TEST_F(SequenceInARoom, AnAnswerTellsWhatIsInFrontOfTheMapAndWhatOfItIsGone) {
  const auto isOne = [](const ViewShares& s) {
    return s.fresh >= 0 && std::abs(s.explained + s.hiding + s.fresh - 1) < 1e-9;
  };
  const Eigen::Vector3d at = truth[10] * Eigen::Vector3d(0.1, 0, 1.3);
  const test::Scene post = test::box({at.x() - 0.15, at.y() - 0.15, 0}, {at.x() + 0.15, at.y() + 0.15, 1.8});
  const View with_post = viewFrom(test::largeRoom() + post, truth[10], 5);
  const double in_front = nearerShare(with_post, views[10]);
  ASSERT_GT(in_front, 0.1);
  Localizer sequence(map);
  for (const Localization& answer : {Localizer(map).localize(views[10]), sequence.update(views[10], 0)}) {
    ASSERT_TRUE(answer.shares && isOne(*answer.shares));
    EXPECT_GT(answer.shares->explained, 0.9);
    EXPECT_LT(answer.shares->hiding, 0.02);
    EXPECT_LT(answer.shares->missing, 0.02);
  }
  for (const Localization& answer : {Localizer(map).localize(with_post), sequence.update(with_post, 0.1)}) {
    ASSERT_TRUE(answer.shares && isOne(*answer.shares));
    EXPECT_NEAR(answer.shares->hiding, in_front, 0.05);
    EXPECT_LT(answer.shares->missing, 0.02);
  }
  Map furnished = *map;
  for (LocalModel& model : furnished.models) model = modelAt(test::largeRoom() + post, *model.T_w_m, 7);
  const Localization without = Localizer(std::make_shared<const Map>(furnished)).localize(views[10]);
  ASSERT_TRUE(without.shares && isOne(*without.shares));
  EXPECT_LT(without.shares->hiding, 0.05);
  EXPECT_GT(without.shares->missing, 0.5 * in_front);
  EXPECT_LT(without.shares->missing, 2 * in_front);
  EXPECT_FALSE(Localizer(std::make_shared<const Map>()).localize(views[10]).shares);
}

TEST_F(SequenceInARoom, ACameraOnItsSideIsFoundAsAnUprightOne) {
  for (const int quarters : {1, 2, 3}) {
    const Eigen::Isometry3d roll(Eigen::AngleAxisd(quarters * EIGEN_PI / 2, Eigen::Vector3d::UnitZ()));
    Localizer sequence(map);
    int sure = 0;
    for (int i = 0; i < kViews; ++i) {
      const Eigen::Isometry3d T_w_c = truth[i] * roll;
      const Localization answer = sequence.update(viewFrom(test::largeRoom(), T_w_c, 1 + i), i * kFrame);
      EXPECT_FALSE(isSureAndWrong(answer, T_w_c)) << quarters << ", " << i;
      sure += answer.state == AnswerState::sure;
    }
    EXPECT_GE(sure, kViews - 30) << quarters;
  }
}

TEST_F(SequenceInARoom, ViewsInAFileGiveTheAnswersOfThoseInMemory) {
  Localizer in_file(map), in_memory(test::inMemory(*map));
  for (int i = 0; i < 15; ++i) {
    const Localization a = in_file.update(views[i], i * kFrame), b = in_memory.update(views[i], i * kFrame);
    test::expectSame(a, b);
    EXPECT_EQ(a.tracking, b.tracking);
    ASSERT_EQ(a.T_w_c.has_value(), b.T_w_c.has_value()) << i;
    if (!a.T_w_c) continue;
    EXPECT_EQ(a.T_w_c->T.matrix(), b.T_w_c->T.matrix());
    EXPECT_EQ(a.T_w_c->P, b.T_w_c->P);
  }
}

TEST_F(SequenceInARoom, StandingStillSharpensNothing) {
  Localizer sequence(map);
  const Localization first = sequence.update(views[0], 0);
  ASSERT_FALSE(first.hypotheses.empty());
  Localization last;
  for (int i = 1; i < 200; ++i) {
    const View again = viewFrom(test::largeRoom(), truth[0], static_cast<unsigned>(2000 + i % 10));
    last = sequence.update(again, i * kFrame);
    EXPECT_EQ(last.state, first.state) << i;
  }
  ASSERT_FALSE(last.hypotheses.empty());
  // Its odometry moves by its noise now and then; a look after next to no motion adds next to nothing.
  EXPECT_NEAR(last.not_in_map.value(), first.not_in_map.value(), 0.05);
}

TEST_F(SequenceInARoom, CarriedAwayItBeginsAnew) {
  Localizer sequence(map);
  int i = 0;
  for (; i < 20; ++i) sequence.update(views[i], i * kFrame);
  bool said = false;
  int sure_after = -1;
  for (int k = 0; k < 20; ++k, ++i) {
    const Localization answer = sequence.update(views[40 + k], i * kFrame);
    said = said || answer.began_anew;
    EXPECT_FALSE(isSureAndWrong(answer, truth[40 + k])) << k;
    if (sure_after < 0 && answer.state == AnswerState::sure) sure_after = k;
  }
  EXPECT_TRUE(said);
  EXPECT_GE(sure_after, 0);
  EXPECT_LE(sure_after, 10) << "within a second";
}

TEST_F(SequenceInARoom, CarriedAwayWithWheelsThatStandStillItBeginsAnew) {
  Localizer sequence(map);
  int i = 0;
  for (; i < 20; ++i) {
    std::optional<PoseWithCovariance> motion;
    if (i > 0) motion = motionTo(i);
    sequence.update(views[i], i * kFrame, motion);
  }
  const PoseWithCovariance still{Eigen::Isometry3d::Identity(), 1e-6 * Matrix6d::Identity()};
  const Localization carried = sequence.update(views[40], i++ * kFrame, still);
  EXPECT_TRUE(carried.began_anew);
  EXPECT_FALSE(isSureAndWrong(carried, truth[40]));
  bool sure = false;
  for (int k = 41; k < 50; ++k, ++i) {
    const Localization answer = sequence.update(views[k], i * kFrame, motionTo(k));
    EXPECT_FALSE(isSureAndWrong(answer, truth[k])) << k;
    sure = sure || answer.state == AnswerState::sure;
  }
  EXPECT_TRUE(sure) << "within a second";
}

TEST_F(SequenceInARoom, PairsAreOfTheViewThatHasThem) {
  Localizer sequence(map);
  int with_pairs = 0;
  for (int i = 0; i < 30; ++i) {
    const Localization answer =
        sequence.update(views[i / 3], i * kFrame);  // one of three counts as an observation
    for (const Hypothesis& h : answer.hypotheses) {
      with_pairs += !h.pairs.empty();
      const std::shared_ptr<const View> model = map->view(h.model);
      for (const SegmentPair& p : h.pairs) {
        const auto& scene = views[i / 3].segments.at(p.scene);
        const Eigen::Vector3d n = h.T_m_c.T.linear() * scene.normal();
        EXPECT_GT(n.dot(model->segments.at(p.model).normal()), 0.95) << i;
      }
    }
  }
  EXPECT_GT(with_pairs, 0);
}

TEST_F(SequenceInARoom, ImagesAreSeenAsViewsAre) {
  Localizer by_views(map), by_images(map);
  for (int i = 0; i < 3; ++i) {
    const DepthImage image =
        test::noisy(test::render(test::largeRoom(), test::smallCamera(), truth[i], 20).image,
                    SensorNoise{}.inverse_depth_std, 1 + i);
    const Localization of_view = by_views.update(views[i], i * kFrame);
    const Localization of_image = by_images.update(image, i * kFrame);
    ASSERT_EQ(of_image.hypotheses.size(), of_view.hypotheses.size()) << i << of_image.reason;
    for (std::size_t k = 0; k < of_image.hypotheses.size(); ++k)
      EXPECT_TRUE(isNear(*of_image.hypotheses[k].T_w_c, *of_view.hypotheses[k].T_w_c, 0.02, 0.5))
          << i << " " << k;
  }
}

/** After a minute in the dark the camera may be anywhere: the first view that is sure decides. */
TEST_F(SequenceInARoom, AfterAGapTheImageDecides) {
  Localizer localizer(map);
  double stamp = 0;
  for (int i = 0; i < 20; ++i) localizer.update(views[i], stamp += kFrame);
  const Localization after = localizer.update(views[50], stamp += 60);
  EXPECT_TRUE(isNearTo(after, truth[50], 0.1, 2));
  EXPECT_EQ(after.state, AnswerState::sure) << after.reason;
}

/** One rule: probable enough, and fixed. */
TEST_F(SequenceInARoom, SureMeansProbableAndFixed) {
  GlobalLocalizationParams strict;
  strict.sure.max_translation = 1e-3;
  const Localization single = Localizer(map, {}, strict).localize(views[0]);
  EXPECT_EQ(single.state, AnswerState::doubtful);
  EXPECT_GT(single.hypotheses.front().probability, 0.9);
  EXPECT_THAT(single.reason, HasSubstr("the place is known, the pose is not: nothing in view fixes"));
  for (const GlobalLocalizationParams& params : {GlobalLocalizationParams(), strict}) {
    Localizer localizer(map, {}, params);
    double stamp = 0;
    for (const View& view : views) {
      const Localization answer = localizer.update(view, stamp += kFrame);
      ASSERT_FALSE(answer.hypotheses.empty());
      const Hypothesis& best = answer.hypotheses.front();
      const Matrix6d P = (*map->models[best.model].T_w_m * best.T_m_c).P;
      EXPECT_EQ(answer.state == AnswerState::sure, best.probability >= 0.9 && params.sure.hold(P));
    }
  }
}

TEST_F(SequenceInARoom, EmptyViewsAreBridged) {
  Localizer sequence(map);
  Localization answer = sequence.update(View(), 0);
  EXPECT_EQ(answer.state, AnswerState::unknown);
  EXPECT_NE(answer.reason, "");
  for (int i = 0; i < 20; ++i) answer = sequence.update(views[i], (1 + i) * kFrame);
  EXPECT_EQ(answer.state, AnswerState::sure) << answer.reason;
  answer = sequence.update(View(), 21 * kFrame);
  answer = sequence.update(views[21], 22 * kFrame);
  EXPECT_FALSE(isSureAndWrong(answer, truth[21]));
}

TEST_F(SequenceInARoom, AnOdometryThatLiesByAFactorOfTwoIsNotBelieved) {
  Localizer sequence(map);
  for (int i = 0; i < kViews; ++i) {
    std::optional<PoseWithCovariance> motion;
    if (i > 0) {
      motion = motionTo(i);
      motion->T = motion->T * motion->T;
    }
    EXPECT_FALSE(isSureAndWrong(sequence.update(views[i], i * kFrame, motion), truth[i])) << i;
  }
}

TEST_F(SequenceInARoom, AnHonestOdometryIsNoHindrance) {
  Localizer sequence(map);
  int sure = 0;
  for (int i = 0; i < kViews; ++i) {
    std::optional<PoseWithCovariance> motion;
    if (i > 0) motion = motionTo(i);
    const Localization answer = sequence.update(views[i], i * kFrame, motion);
    EXPECT_FALSE(isSureAndWrong(answer, truth[i])) << i;
    sure += answer.state == AnswerState::sure;
  }
  EXPECT_GE(sure, kViews - 20);
}

TEST_F(SequenceInARoom, AMissingPlaceIsNotFound) {
  Localizer sequence(map);
  for (int i = 0; i < 20; ++i) {
    const double a = 0.06 * i;
    const View elsewhere =
        viewFrom(test::furnishedRoom(),
                 lookingAlong({1.5, 1 + 0.03 * i, 1.3}, {std::sin(a), std::cos(a), -0.2}), 1 + i);
    EXPECT_NE(sequence.update(elsewhere, i * kFrame).state, AnswerState::sure) << i;
  }
}

TEST_F(SequenceInARoom, TheSameViewsGiveTheSameBytesForAnyNumberOfThreads) {
  const auto bytes = [&](int threads) {
    Localizer sequence(map);
    sequence.setNumberOfThreads(threads);
    std::string out;
    for (int i = 0; i < 20; ++i) {
      const Localization answer = sequence.update(views[i < 12 ? i : i + 30], i * kFrame);
      out += std::string(stateName(answer.tracking)) + answer.reason;
      if (answer.T_w_c) {
        out.append(reinterpret_cast<const char*>(answer.T_w_c->T.data()), 16 * sizeof(double));
        out.append(reinterpret_cast<const char*>(answer.T_w_c->P.data()), 36 * sizeof(double));
      }
      for (const Hypothesis& h : answer.hypotheses) {
        out.append(reinterpret_cast<const char*>(h.T_w_c->data()), 16 * sizeof(double));
        out.append(reinterpret_cast<const char*>(&h.probability), sizeof h.probability);
      }
    }
    return out;
  };
  const std::string once = bytes(1);
  EXPECT_GT(once.size(), 1000u);
  EXPECT_EQ(once, bytes(2));
}

/** Two rooms, 20 m apart, equal but for a cupboard that one of them has behind. */
class SequenceInTwinRooms : public testing::Test {
protected:
  static constexpr int kViews = 50;
  static Eigen::Isometry3d shifted(Eigen::Isometry3d T) {
    T.translation().x() += 20;
    return T;
  }
  void SetUp() override {
    const test::Scene plain = test::largeRoom(),
                      other = test::largeRoom() + test::box({1, 2.9, 0}, {1.9, 3.5, 1.4});
    for (int i = 0; i < 18; ++i) map->models.push_back(modelAt(plain, onCircle(20 * i, 0.35), 1000 + i));
    for (int i = 0; i < 18; ++i) {
      LocalModel m = modelAt(other, onCircle(20 * i, 0.35), 2000 + i);
      m.T_w_m = shifted(*m.T_w_m);
      map->models.push_back(std::move(m));
    }
    map = test::openedMap(*map);
    for (int i = 0; i < kViews; ++i) {
      const Eigen::Isometry3d there = onCircle(degrees(i), 0.4);
      truth.push_back(shifted(there));
      views.push_back(viewFrom(other, there, 1 + i));
    }
  }
  /** It begins with its back to the cupboard, which is at 165 deg, and turns to it. */
  static double degrees(int i) { return -40 + 4 * i; }

  /** How many of the first twenty views are sure; none may be wrong. */
  int sureOfTwenty(Localizer& localizer) const {
    int sure = 0;
    for (int i = 0; i < 20; ++i) {
      const Localization answer = localizer.update(views[i], i * kFrame);
      EXPECT_FALSE(isSureAndWrong(answer, truth[i])) << i;
      sure += answer.state == AnswerState::sure;
    }
    return sure;
  }

  std::shared_ptr<Map> map = std::make_shared<Map>();
  std::vector<Eigen::Isometry3d> truth;
  std::vector<View> views;
};

TEST_F(SequenceInTwinRooms, OnlyTheirDifferenceDecides) {
  Localizer sequence(map);
  int sure_before = 0;
  Localization answer;
  for (int i = 0; i < kViews; ++i) {
    answer = sequence.update(views[i], i * kFrame);
    EXPECT_FALSE(isSureAndWrong(answer, truth[i])) << i;
    if (degrees(i) < 90) sure_before += answer.state == AnswerState::sure;
    if (i == 20) {
      ASSERT_GE(answer.hypotheses.size(), 2u);
      EXPECT_NEAR(answer.hypotheses[0].probability, answer.hypotheses[1].probability, 0.3);
      EXPECT_GT(answer.hypotheses[0].probability + answer.hypotheses[1].probability, 0.8);
    }
  }
  EXPECT_EQ(sure_before, 0);
  EXPECT_EQ(answer.state, AnswerState::sure) << answer.reason;
  EXPECT_TRUE(isNearTo(answer, truth.back(), 0.1, 2));
}

/** About 0.6 m and 15 deg off. */
PoseWithCovariance startNear(const Eigen::Isometry3d& T_w_c) {
  PoseWithCovariance start;
  start.T = Eigen::Translation3d(0.4, -0.4, 0) * T_w_c;
  start.T.linear() = Eigen::AngleAxisd(15 * kDegree, Eigen::Vector3d::UnitZ()) * start.T.linear();
  start.P = Matrix6d::Identity();
  start.P.topLeftCorner<3, 3>() *= 30 * kDegree * 30 * kDegree;
  return start;
}

TEST_F(SequenceInTwinRooms, AStartDecidesBetweenThem) {
  Localizer localizer(map);
  localizer.setPose(startNear(truth[0]));
  EXPECT_GE(sureOfTwenty(localizer), 15);
}

TEST_F(SequenceInTwinRooms, AStartDecidesWithoutAHeading) {
  for (const double wrong_by_deg : {0.0, 100.0, 180.0}) {
    Localizer localizer(map);
    PoseWithCovariance start = startNear(truth[0]);
    start.T.linear() = Eigen::AngleAxisd(wrong_by_deg * kDegree, Eigen::Vector3d::UnitZ()) * start.T.linear();
    start.P(2, 2) = EIGEN_PI * EIGEN_PI;
    localizer.setPose(start);
    EXPECT_GE(sureOfTwenty(localizer), 15) << wrong_by_deg;
  }
}

TEST_F(SequenceInARoom, AWrongStartIsLeft) {
  Localizer localizer(map);
  localizer.setPose(startNear(truth[45]));
  Localization answer;
  for (int i = 0; i < 30; ++i) {
    answer = localizer.update(views[i], i * kFrame);
    EXPECT_FALSE(isSureAndWrong(answer, truth[i])) << i;
  }
  EXPECT_EQ(answer.state, AnswerState::sure) << answer.reason << " after a second";
}

TEST_F(SequenceInTwinRooms, AGuessDecidesForASingleView) {
  const Localizer localizer(map);
  int sure = 0;
  for (int i = 0; i < 12; i += 3) {
    ASSERT_NE(localizer.localize(views[i]).state, AnswerState::sure) << i;
    const Localization answer = localizer.localize(views[i], startNear(truth[i]));
    EXPECT_FALSE(isSureAndWrong(answer, truth[i])) << i;
    sure += answer.state == AnswerState::sure;
    const Localization again = localizer.localize(views[i], startNear(truth[i]));
    EXPECT_EQ(again.hypotheses.size(), answer.hypotheses.size()) << "it remembers nothing";
  }
  EXPECT_GE(sure, 3);
}

TEST_F(SequenceInARoom, AWrongGuessIsNoAnswer) {
  const Localizer localizer(map);
  for (int i = 0; i < 12; i += 3) {
    const Localization answer = localizer.localize(views[i], startNear(truth[i + 45]));
    EXPECT_FALSE(isSureAndWrong(answer, truth[i])) << i;
  }
  EXPECT_THROW(localizer.localize(views[0], PoseWithCovariance()), std::invalid_argument);
}

TEST_F(SequenceInARoom, AStartWithoutSenseIsRefused) {
  Localizer localizer(map);
  EXPECT_THROW(localizer.setPose(PoseWithCovariance()), std::invalid_argument) << "no covariance";
  EXPECT_THROW(localizer.setPose(startNear(truth[0]), 7), std::invalid_argument) << "no such part";
  PoseWithCovariance nan = startNear(truth[0]);
  nan.T.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(localizer.setPose(nan), std::invalid_argument);
}

TEST_F(SequenceInARoom, AStartIsKnownBeforeAnythingIsSeen) {
  Localizer localizer(map);
  localizer.setPose(startNear(truth[0]));
  const Localization answer = localizer.update(View(), 0);
  ASSERT_EQ(answer.hypotheses.size(), 1u);
  EXPECT_THAT(*answer.hypotheses[0].T_w_c, test::PoseNear(startNear(truth[0]).T, 1e-9, 1e-6));
  EXPECT_NE(answer.state, AnswerState::sure);
}

TEST_F(SequenceInTwinRooms, LaterViewsAlsoLocateTheFirstOne) {
  Localizer localizer(map);
  std::vector<DriveView> drive;
  for (int i = 0; i < kViews; ++i)
    drive.push_back({views[i], i * kFrame, {}, localizer.update(views[i], i * kFrame)});
  ASSERT_EQ(drive[0].answer.state, AnswerState::doubtful);
  int done = 0;
  const std::vector<Localization> by_all = localizer.smoothed(drive, [&] { ++done; });
  ASSERT_EQ(by_all.size(), drive.size());
  EXPECT_EQ(done, kViews);
  double squares = 0, variances = 0;
  for (int i = 0; i + 1 < kViews; ++i) {
    const Localization& answer = by_all[i];
    EXPECT_EQ(answer.state, AnswerState::sure) << i << ": " << answer.reason;
    EXPECT_TRUE(isNearTo(answer, truth[i], 0.1, 2)) << i;
    double sum = answer.not_in_map.value();
    for (const Hypothesis& h : answer.hypotheses) {
      sum += h.probability;
      const Eigen::Isometry3d T_w_c = *map->models[h.model].T_w_m * h.T_m_c.T;
      EXPECT_TRUE(isNear(T_w_c, *h.T_w_c, 1e-6, 1e-5)) << "one pose in both frames";
    }
    EXPECT_NEAR(sum, 1, 1e-9);
    squares += (answer.hypotheses.front().T_w_c->translation() - truth[i].translation()).squaredNorm();
    variances += answer.hypotheses.front().T_m_c.P.bottomRightCorner<3, 3>().trace();
  }
  EXPECT_LT(squares, 3 * variances) << "views of both directions are not counted twice";
}

TEST_F(SequenceInTwinRooms, TwoDirectionsOfOneViewAreOneView) {
  Localizer localizer(map);
  std::vector<DriveView> drive;
  for (const double stamp : {0.0, kFrame})
    drive.push_back({views[0], stamp, {}, localizer.update(views[0], stamp)});
  EXPECT_NE(localizer.smoothed(drive).front().state, AnswerState::sure);
}

TEST_F(SequenceInTwinRooms, WithoutLaterViewsNothingChanges) {
  Localizer localizer(map);
  const Localization until = localizer.update(views[0], 0);
  PoseWithCovariance none;
  none.P = 1e-8 * Matrix6d::Identity();
  const double prior = -GlobalLocalizationParams().probability.priorLogOdds();
  const Localization smoothed = smoothedPlaces(until, Localization(), none, prior);
  ASSERT_EQ(smoothed.hypotheses.size(), until.hypotheses.size());
  for (std::size_t i = 0; i < smoothed.hypotheses.size(); ++i)
    EXPECT_NEAR(smoothed.hypotheses[i].probability, until.hypotheses[i].probability, 1e-6);
}

class BeliefInARoom : public SequenceInARoom {
protected:
  std::shared_ptr<const View> view(int i) const { return std::make_shared<const View>(views[i]); }
  static double logOdds(const PlaceBelief& belief) { return belief.places().front().log_odds; }
};

TEST_F(BeliefInARoom, ALookCountsByTheMotionSinceTheLast) {
  PlaceBelief belief(map, {}, {});
  EXPECT_TRUE(belief.isDue());
  belief.inject(0, {truth[0], 1e-4 * Matrix6d::Identity()});
  belief.observe(view(0), {});
  ASSERT_EQ(belief.places().size(), 1u);
  const double first = logOdds(belief);
  EXPECT_GT(first, 0);
  EXPECT_FALSE(belief.isDue());
  belief.observe(view(0), {});
  EXPECT_DOUBLE_EQ(logOdds(belief), first) << "it has not moved";
  PoseWithCovariance there_and_back;  // half the independent distance
  there_and_back.T.translation().x() = SequenceCalibration{}.independent_distance / 4;
  belief.move(Motion::known(there_and_back));
  there_and_back.T = there_and_back.T.inverse();
  belief.move(Motion::known(there_and_back));
  EXPECT_TRUE(belief.isDue());
  belief.observe(view(0), {});
  EXPECT_NEAR(logOdds(belief), first + (1 - std::exp(-0.5)) * first, 0.05 * first);
}

TEST_F(BeliefInARoom, ItNeverBecomesSurerThanItsBound) {
  LocalizerParams params;
  params.max_places = 3;
  PlaceBelief belief(map, {}, params);
  const GlobalLocalization localization(map);
  for (int i = 0; i < 20; ++i) {
    if (i > 0) belief.move(Motion::known(motionTo(i)));
    const Localization found = localization.localize(views[i]);
    belief.observe(view(i), found);
    ASSERT_FALSE(belief.places().empty());
    EXPECT_LE(logOdds(belief), kMostLogOdds);
    EXPECT_LE(belief.places().size(), 3u);
  }
  EXPECT_DOUBLE_EQ(logOdds(belief), kMostLogOdds);
}

TEST_F(BeliefInARoom, TheMostProbablePlacesAreKept) {
  LocalizerParams params;
  for (const int most : {12, 3}) {
    params.max_places = most;
    PlaceBelief belief(map, {}, params);
    for (const int i : {50, 40, 30, 15, 0}) belief.inject(0, {truth[i], 1e-4 * Matrix6d::Identity()});
    belief.observe(view(0), {});
    ASSERT_EQ(belief.places().size(), most == 3 ? 3u : 5u);
    EXPECT_TRUE(isNear(belief.places().front().T_w_c.T, truth[0], 0.05, 1));
  }
}

TEST_F(BeliefInARoom, AnOpenHeadingIsAllHeadings) {
  PlaceBelief belief(map, {}, {});
  PoseWithCovariance start{truth[0], Matrix6d::Identity()};
  start.P(2, 2) = 4;
  start.P(2, 3) = start.P(3, 2) = 0.5;
  belief.inject(0, start, 7);
  PlaceBelief known(map, {}, {});
  known.inject(0, {truth[0], 0.01 * Matrix6d::Identity()}, 7);
  ASSERT_EQ(belief.places().size(), 12u);
  double sum = 0;
  for (const BelievedPlace& place : belief.places()) {
    sum += place.probability;
    EXPECT_THAT(place.T_w_c.T.translation(), test::MatrixNear(truth[0].translation(), 1e-12));
    EXPECT_NEAR(std::sqrt(place.T_w_c.P(2, 2)), 15 * kDegree, 1e-9);
    EXPECT_EQ(Eigen::LLT<Matrix6d>(place.T_w_c.P).info(), Eigen::Success);
  }
  EXPECT_NEAR(sum, known.places().front().probability, 1e-9);
}

TEST_F(BeliefInARoom, PlacesMoveWithTheCamera) {
  PlaceBelief belief(map, {}, {});
  PoseWithCovariance place{truth[0], 1e-4 * Matrix6d::Identity()};
  place.P(0, 4) = place.P(4, 0) = 2e-5;
  belief.inject(0, place);
  PoseWithCovariance motion{truth[0].inverse() * truth[3], 1e-5 * Matrix6d::Identity()};
  belief.move(Motion::known(motion));
  const PoseWithCovariance expected = place * motion;
  EXPECT_THAT(belief.places().front().T_w_c.T, test::PoseNear(expected.T, 1e-12, 1e-9));
  EXPECT_THAT(belief.places().front().T_w_c.P, test::MatrixNear(expected.P, 1e-12));
}

TEST_F(BeliefInARoom, AMotionOfTwoAnswersMakesTwoPlaces) {
  PlaceBelief belief(map, {}, {});
  belief.inject(0, {truth[0], 1e-4 * Matrix6d::Identity()});
  const Matrix6d P = 1e-5 * Matrix6d::Identity();
  Motion motion = Motion::known({truth[0].inverse() * truth[3], P});
  motion.modes = {{{truth[0].inverse() * truth[40], P}, 0.6}, {{truth[0].inverse() * truth[3], P}, 0.4}};
  belief.move(motion);
  ASSERT_EQ(belief.places().size(), 2u);
  EXPECT_NEAR(belief.places()[0].probability / belief.places()[1].probability, 1.5, 1e-9);
  EXPECT_THAT(belief.places()[1].T_w_c.T, test::PoseNear(truth[3], 1e-9, 1e-6));
  belief.observe(view(3), {});  // which decides
  ASSERT_FALSE(belief.places().empty());
  EXPECT_THAT(belief.places()[0].T_w_c.T, test::PoseNear(truth[3], 0.05, 1));
  EXPECT_GT(belief.places()[0].probability,
            0.9 * (belief.places()[0].probability +
                   (belief.places().size() > 1 ? belief.places()[1].probability : 0)));
}

TEST_F(BeliefInARoom, AJumpMovesOddsToNowhere) {
  PlaceBelief belief(map, {}, {});
  belief.inject(0, {truth[0], 1e-4 * Matrix6d::Identity()}, 3);
  const double before = belief.places().front().probability;
  Motion motion = Motion::known({truth[0].inverse() * truth[3], 1e-5 * Matrix6d::Identity()});
  motion.none = 0.3;
  belief.move(motion);
  ASSERT_EQ(belief.places().size(), 1u);
  EXPECT_NEAR(belief.places().front().probability, 0.7 * before, 1e-9);
}

/** Log odds of the view against all else, less four nats for a motion that leads elsewhere. */
TEST_F(BeliefInARoom, ASureViewOfAnotherPlaceIsHeard) {
  PlaceBelief belief(map, {}, {});
  belief.inject(0, {truth[0], 1e-4 * Matrix6d::Identity()}, 7);
  const double nowhere = 1 - belief.places().front().probability;
  Localization found = GlobalLocalization(map).localize(views[30]);
  ASSERT_EQ(found.state, AnswerState::sure);
  Hypothesis sure = found.hypotheses.front();
  sure.probability = 0.99;
  belief.hear(sure);
  ASSERT_EQ(belief.places().size(), 2u);
  const double heard = std::exp(std::log(99) - 4), all = 1 + heard;
  EXPECT_THAT(belief.places()[0].T_w_c.T, test::PoseNear(truth[30], 0.05, 1));
  EXPECT_NEAR(belief.places()[0].probability, heard / all, 1e-3);
  EXPECT_NEAR(belief.places()[1].probability, (1 - nowhere) / all, 1e-3);
}

TEST_F(BeliefInARoom, ASureViewOfTheSamePlaceChangesNoOdds) {
  PlaceBelief belief(map, {}, {});
  belief.inject(0, {truth[30], 1e-4 * Matrix6d::Identity()}, 1);
  const double before = logOdds(belief);
  Localization found = GlobalLocalization(map).localize(views[30]);
  ASSERT_EQ(found.state, AnswerState::sure);
  belief.hear(found.hypotheses.front());
  EXPECT_EQ(logOdds(belief), before);
}

/** The wall of the map is at 2.4 m, the view sees as far as 5.2 m. */
TEST_F(BeliefInARoom, ViewsThatLookThroughTheMapSpeakAgainstAPlaceBeyondDoubt) {
  PlaceBelief belief(map, {}, {});
  belief.inject(0, {onCircle(0, 0.6), 1e-4 * Matrix6d::Identity()}, 7);
  const double before = logOdds(belief);
  const Eigen::Isometry3d far = lookingAlong({0.8, 2.5, 1.2}, {1, 0, -0.4});
  belief.observe(std::make_shared<const View>(viewFrom(test::largeRoom(), far, 1)), {});
  ASSERT_EQ(belief.places().size(), 1u);
  EXPECT_LT(belief.places()[0].match.coverage.contradicted, 0.2) << "it is not hidden by anything new";
  EXPECT_GT(belief.places()[0].match.coverage.looked_through, 0.5);
  EXPECT_LT(logOdds(belief), before - 0.5);
  EXPECT_GE(logOdds(belief), before - 1 - 1e-9) << "what has changed stays in view for several looks";
}

TEST_F(BeliefInARoom, TheViewIsAskedNearAPlaceThatIsWrong) {
  PlaceBelief belief(map, {}, {});
  const Eigen::Isometry3d off = boxplus(truth[0], (Vector6d() << 0, 0, 0.2, 0.35, -0.2, 0).finished());
  PoseWithCovariance wrong{off, 1e-4 * Matrix6d::Identity()};
  wrong.P.diagonal().tail<3>().setConstant(0.04);
  wrong.P.diagonal().head<3>().setConstant(0.01);
  belief.inject(0, wrong);
  const Localization found = GlobalLocalization(map).localize(views[0]);
  belief.observe(view(0), found);
  ASSERT_FALSE(belief.places().empty());
  EXPECT_THAT(belief.places().front().T_w_c.T, test::PoseNear(truth[0], 0.05, 1));
}

}  // namespace
}  // namespace facetloc
