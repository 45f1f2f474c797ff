// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/map_ambiguity.h"
#include "opened_map.h"
#include "pairs/view_registration.h"
#include "ranking/global_localization.h"
#include "ranking/place_ranking.h"

#include <facetloc/testing/changed_views.h>
#include <facetloc/testing/matchers.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/random_segments.h>
#include <facetloc/testing/synthetic_views.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

namespace facetloc {
namespace {

using namespace internal;
using test::endlessPlane, test::lookingAlong, test::mounted, test::PoseNear, test::Rng, test::uniform,
    test::viewFrom, testing::HasSubstr;

LocalModel modelAt(const test::Scene& scene, const Eigen::Isometry3d& T_w_m, unsigned seed) {
  return {"", 0, T_w_m, viewFrom(scene, T_w_m, seed)};
}

std::shared_ptr<Map> mapOf(const test::Scene& scene, const std::vector<Eigen::Isometry3d>& poses) {
  auto map = std::make_shared<Map>();
  for (std::size_t i = 0; i < poses.size(); ++i)
    map->models.push_back(modelAt(scene, poses[i], 100 + unsigned(i)));
  return map;
}

// A camera carried around the room on a loop, looking outwards, every 45 deg.
std::vector<Eigen::Isometry3d> loop() {
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < 8; ++i) {
    const double a = i * EIGEN_PI / 4;
    poses.push_back(lookingAlong({3 + 0.5 * std::cos(a), 2.5 + 0.4 * std::sin(a), 1.2},
                                 {std::cos(a), std::sin(a), -0.2}));
  }
  return poses;
}

class LocalizationInARoom : public testing::Test {
protected:
  static void SetUpTestSuite() { map = test::openedMap(*mapOf(test::largeRoom(), loop())); }
  static void TearDownTestSuite() { map.reset(); }
  static inline std::shared_ptr<const Map> map;
};

TEST_F(LocalizationInARoom, EveryMapImageIsFoundAtItsOwnPlace) {
  GlobalLocalizationParams planes_only;  // which are the same in both; other models' noise is not
  planes_only.refinement.enabled = false;
  const GlobalLocalization localization(map, planes_only);
  for (std::size_t i = 0; i < map->models.size(); ++i) {
    const Localization answer = localization.localize(*map->view(i));
    ASSERT_FALSE(answer.hypotheses.empty()) << i << ": " << answer.reason;
    EXPECT_EQ(answer.reason, "");
    EXPECT_EQ(answer.hypotheses[0].model, static_cast<int>(i));
    EXPECT_THAT(answer.hypotheses[0].T_m_c.T, PoseNear(Eigen::Isometry3d::Identity(), 0.005, 0.1));
    EXPECT_THAT(*answer.hypotheses[0].T_w_c, PoseNear(*map->models[i].T_w_m, 0.005, 0.1));
  }
}

TEST_F(LocalizationInARoom, ViewsInAFileGiveTheAnswersOfThoseInMemory) {
  const GlobalLocalization in_file(map), in_memory(test::inMemory(*map));
  ASSERT_TRUE(map->store());
  for (unsigned i = 0; i < 3; ++i) {
    const View view = viewFrom(test::largeRoom(), lookingAlong({3.1, 2.4, 1.3}, {1, 2. * i - 2, -0.2}), i);
    const Localization answer = in_file.localize(view);
    EXPECT_FALSE(answer.hypotheses.empty()) << answer.reason;
    test::expectSame(answer, in_memory.localize(view));
  }
}

/** A camera that is turned about its optical axis by quarter turns. */
Eigen::Isometry3d rolled(const Eigen::Isometry3d& T_w_c, int quarters) {
  return T_w_c * Eigen::AngleAxisd(quarters * EIGEN_PI / 2, Eigen::Vector3d::UnitZ());
}

TEST_F(LocalizationInARoom, ATurnedCameraIsFound) {
  const GlobalLocalization localization(map);
  int sure = 0;
  for (const double side : {-2.0, -1.0, 0.0, 1.0, 2.0}) {
    const Eigen::Isometry3d straight = lookingAlong({3.1, 2.4, 1.3}, {1, side, -0.2});
    if (localization.localize(viewFrom(test::largeRoom(), straight, 7)).state != AnswerState::sure) continue;
    ++sure;
    for (int quarters = 1; quarters < 4; ++quarters) {
      const Eigen::Isometry3d T_w_c = rolled(straight, quarters);
      const Localization answer = localization.localize(viewFrom(test::largeRoom(), T_w_c, 7));
      ASSERT_FALSE(answer.hypotheses.empty()) << side << ", " << quarters;
      EXPECT_THAT(*answer.hypotheses[0].T_w_c, PoseNear(T_w_c, 0.05, 1)) << side << ", " << quarters;
      EXPECT_GT(answer.hypotheses[0].probability, 0.1) << "one camera of ten is turned";
    }
  }
  EXPECT_GE(sure, 2);
}

TEST_F(LocalizationInARoom, TwoMountingsSayHowTheCameraIsTurned) {
  auto on_robot = std::make_shared<Map>(*map);
  on_robot->camera.mounting = CameraMounting{1.2, 10};
  CameraMounting upside_down = *on_robot->camera.mounting;
  upside_down.roll_deg = 180;
  const GlobalLocalization localization(on_robot);
  const Eigen::Isometry3d T_w_c = rolled(lookingAlong({3.1, 2.4, 1.2}, {1, 0.2, -std::tan(10 * kDegree)}), 2);
  const View view = mounted(viewFrom(test::largeRoom(), T_w_c, 8), upside_down);
  EXPECT_GT(rotationAngle(localization.prior(view).T.linear()), 170 * kDegree);
  const Localization answer = localization.localize(view);
  EXPECT_EQ(answer.camera.mounting, CameraDifference::Mounting::other);
  ASSERT_EQ(answer.state, AnswerState::sure);
  EXPECT_THAT(*answer.hypotheses[0].T_w_c, PoseNear(T_w_c, 0.05, 1));
}

TEST_F(LocalizationInARoom, ModelsThatAreExcludedFindNothing) {
  const GlobalLocalization localization(map);
  const Localization answer = localization.localize(*map->view(3), [](int model) { return model % 2 == 1; });
  ASSERT_FALSE(answer.hypotheses.empty());
  for (const Hypothesis& h : answer.hypotheses)
    for (const int model : h.supporting_models) EXPECT_EQ(model % 2, 0);
  EXPECT_TRUE(localization.localize(*map->view(3), [](int) { return true; }).hypotheses.empty());
}

/** Two rooms that are the same: whatever is seen in the one fits the other. */
TEST_F(LocalizationInARoom, AMapOfTwinsKnowsThatItIsAmbiguous) {
  auto twins = std::make_shared<Map>(*map);
  const int n = static_cast<int>(map->models.size());
  const Eigen::Translation3d away(50, 0, 0);
  for (LocalModel model : map->models) {
    model.name += "'";
    model.T_w_m = away * *model.T_w_m;
    twins->models.push_back(std::move(model));
  }
  const GlobalLocalization alone(map), two(twins);
  const auto first_room = [n](int model) { return model < n; };
  for (const int i : {0, n / 2}) {
    EXPECT_FALSE(wrongPlace(alone, i, first_room)) << "there is no other place";
    const auto wrong = wrongPlace(two, i, first_room);
    ASSERT_TRUE(wrong);
    EXPECT_THAT(*wrong->T_w_c, PoseNear(away * *map->models[i].T_w_m, 0.02, 0.5));
    EXPECT_GT(wrong->score, 0);
  }
  EXPECT_FALSE(ambiguityOf(AliasScores()));
}

TEST(MapAmbiguity, IsTheMeanOfTheHighestTenth) {
  AliasScores scores = {{}, {}};                                 // nothing of two models
  for (int i = 0; i < 40; ++i) scores.push_back((i * 17) % 40);  // 0 ... 39 in another order
  const auto found = ambiguityOf(scores);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->views, 40);
  EXPECT_DOUBLE_EQ(found->score, 37.5);
  EXPECT_DOUBLE_EQ(ambiguityOf(AliasScores{-3})->score, -3);
}

TEST_F(LocalizationInARoom, AModelThatCannotBeReadIsAnErrorForAnyNumberOfThreads) {
  struct BrokenStore : MapStore {
    std::shared_ptr<const View> view(int i) const override {
      throw std::runtime_error("local model " + std::to_string(i) + " is damaged");
    }
    bool hasPicture(int) const override { return true; }
  };
  auto broken = std::make_shared<Map>(*map);
  broken->setStore(std::make_shared<BrokenStore>());
  GlobalLocalizationParams likeliest_first, all;
  all.shortlist.size = 0;
  const auto errorOf = [&](const GlobalLocalizationParams& params, int threads) {
    GlobalLocalization localization(broken, params);
    localization.setNumberOfThreads(threads);
    return test::messageOf<std::runtime_error>([&] { localization.localize(*map->view(3)); });
  };
  for (const int threads : {1, 2}) {
    EXPECT_EQ(errorOf(all, threads), "local model 0 is damaged");
    EXPECT_EQ(errorOf(likeliest_first, threads), errorOf(likeliest_first, 1));
    EXPECT_NE(errorOf(likeliest_first, threads), "");
  }
}

TEST_F(LocalizationInARoom, EveryMapImageAgreesWithItsNeighbours) {
  const GlobalLocalization localization(map);
  for (int i = 0; i < static_cast<int>(map->models.size()); ++i) {
    const Localization answer = localization.localize(*map->view(i));
    ASSERT_FALSE(answer.hypotheses.empty()) << answer.reason;
    EXPECT_THAT(*answer.hypotheses[0].T_w_c, PoseNear(*map->models[i].T_w_m, 0.015, 0.2));
  }
}

TEST_F(LocalizationInARoom, ModelsThatAreAskedOneByOneGiveTheSameAnswer) {
  GlobalLocalizationParams all;
  all.shortlist.size = 0;
  const GlobalLocalization localization(map, all);
  const View scene = *map->view(3);
  const Query query(scene, localization.prior(scene));
  const ViewRegistration registration;
  std::vector<Hypothesis> one_by_one;
  for (std::size_t i = 0; i < map->models.size(); ++i)
    for (Hypothesis h : registration.align(query, *map->view(i))) {
      h.model = static_cast<int>(i);
      h.T_w_c = *map->models[i].T_w_m * h.T_m_c.T;
      one_by_one.push_back(h);
    }
  PlaceRanking(map, {}).rank(scene, one_by_one);
  const Localization whole = localization.localize(scene);
  ASSERT_FALSE(whole.hypotheses.empty());
  ASSERT_EQ(one_by_one.size(), whole.hypotheses.size());
  for (std::size_t i = 0; i < whole.hypotheses.size(); ++i) {
    EXPECT_EQ(one_by_one[i].model, whole.hypotheses[i].model);
    EXPECT_EQ(one_by_one[i].score, whole.hypotheses[i].score);
    EXPECT_TRUE(one_by_one[i].T_w_c->isApprox(*whole.hypotheses[i].T_w_c, 0));
  }
}

TEST_F(LocalizationInARoom, NewImagesWhosePlanesFixThePoseAreFound) {
  const GlobalLocalization localization(map);
  Rng rng(1);
  int fixed = 0, correct = 0, confident_and_wrong = 0;
  for (unsigned i = 0; i < 24; ++i) {
    const double a = uniform(rng, 0, 2 * EIGEN_PI), radius = uniform(rng, 0.2, 0.8);
    const Eigen::Vector3d position{3 + radius * std::cos(a), 2.5 + radius * std::sin(a),
                                   uniform(rng, 1.1, 1.3)};
    const Eigen::Isometry3d truth =
        lookingAlong(position, {std::cos(a), std::sin(a), uniform(rng, -0.3, -0.1)});
    const View view = viewFrom(test::largeRoom(), truth, 200 + i);
    const Localization answer = localization.localize(view);
    bool is_correct = false;
    if (!answer.hypotheses.empty()) {
      const Vector6d e = boxminus(*answer.hypotheses[0].T_w_c, truth);
      is_correct = e.head<3>().norm() < 2 * kDegree && e.tail<3>().norm() < 0.2;
      confident_and_wrong += !is_correct && answer.hypotheses[0].probability > 0.9;
    }
    if (!unconstrainedDirections(Query(view), {}).empty()) continue;
    ++fixed;
    correct += is_correct;
  }
  EXPECT_GE(fixed, 16);
  EXPECT_GE(correct, 0.95 * fixed);
  EXPECT_EQ(confident_and_wrong, 0);
}

TEST_F(LocalizationInARoom, TheListIsSortedMergedAndItsProbabilitiesLeaveRoomForNone) {
  const Localization answer = GlobalLocalization(map).localize(
      viewFrom(test::largeRoom(), lookingAlong({3.2, 2.6, 1.2}, {1, 0.4, -0.2}), 7));
  ASSERT_FALSE(answer.hypotheses.empty());
  double sum = 0;
  for (std::size_t i = 0; i < answer.hypotheses.size(); ++i) {
    const Hypothesis& h = answer.hypotheses[i];
    sum += h.probability;
    EXPECT_THAT(*h.T_w_c, PoseNear(*map->models[h.model].T_w_m * h.T_m_c.T, 1e-12, 1e-9));
    const double support = EvidenceCalibration().support_weight * std::log(h.supporting_models.size());
    EXPECT_NEAR(h.score, h.consensus + h.evidence + support, 1e-9);
    for (std::size_t k = 0; k < i; ++k) {
      EXPECT_LE(h.score, answer.hypotheses[k].score);
      const Vector6d e = boxminus(*h.T_w_c, *answer.hypotheses[k].T_w_c);
      EXPECT_TRUE(e.head<3>().norm() > 2 * kDegree || e.tail<3>().norm() > 0.15);
    }
  }
  EXPECT_GT(sum, 0.5);
  EXPECT_LT(sum, 1);
}

TEST_F(LocalizationInARoom, AnImageOfAnotherRoomIsMostLikelyNowhere) {
  const test::Scene elsewhere = test::box({0, 0, 0}, {3.3, 7, 3.1}) +
                                test::box({1.1, 2.6, 0}, {2.2, 3.1, 2.2}) +
                                test::box({0, 4, 0.9}, {0.8, 6, 1.4});
  const GlobalLocalization localization(map);
  for (unsigned i = 0; i < 4; ++i) {
    const Localization answer = localization.localize(
        viewFrom(elsewhere, lookingAlong({1.5, 1 + 0.2 * i, 1.3}, {0.1 * i, 1, -0.2}), i));
    double sum = 0;
    for (const Hypothesis& h : answer.hypotheses) sum += h.probability;
    EXPECT_LT(sum, 0.5);
  }
}

// Everything that an answer holds, bit by bit.
std::string bytesOf(const Localization& answer) {
  std::string bytes = answer.reason;
  const auto put = [&bytes](const void* data, std::size_t n) {
    bytes.append(static_cast<const char*>(data), n);
  };
  for (const Hypothesis& h : answer.hypotheses) {
    put(&h.model, sizeof h.model);
    put(h.T_m_c.T.data(), 16 * sizeof(double));
    put(h.T_m_c.P.data(), 36 * sizeof(double));
    for (const double x : {h.consensus, h.free_space, h.evidence, h.score, h.probability}) put(&x, sizeof x);
    for (const SegmentPair& p : h.pairs) {
      put(&p.scene, sizeof p.scene);
      put(&p.model, sizeof p.model);
      put(&p.distance, sizeof p.distance);
    }
  }
  return bytes;
}

TEST_F(LocalizationInARoom, TheAnswerDoesNotDependOnThreadsOrRepetition) {
  const View scene = viewFrom(test::largeRoom(), lookingAlong({3.2, 2.6, 1.2}, {1, 0.4, -0.2}), 7);
  GlobalLocalization localization(map);
  const std::string once = bytesOf(localization.localize(scene));
  ASSERT_GT(once.size(), 100u);
  for (const int threads : {1, 2, 3, 8, 0}) {
    localization.setNumberOfThreads(threads);
    for (int repetition = 0; repetition < 2; ++repetition)
      EXPECT_EQ(bytesOf(localization.localize(scene)), once) << threads << " threads";
  }
}

TEST_F(LocalizationInARoom, SegmentsSufficeWithoutDepthPicturesOrWorldPoses) {
  auto bare = std::make_shared<Map>(*map);
  for (LocalModel& m : bare->models) m.T_w_m.reset();
  test::changeViews(*bare, [](View& view) { view.depth = {}; });
  View scene = *map->view(1);  // its planes alone fix the pose
  scene.depth = {};
  const Localization answer = GlobalLocalization(bare).localize(scene);
  ASSERT_FALSE(answer.hypotheses.empty());
  EXPECT_EQ(answer.hypotheses[0].model, 1);
  EXPECT_FALSE(answer.hypotheses[0].T_w_c);
  EXPECT_EQ(answer.hypotheses[0].evidence, 0);
  double sum = 0;
  for (const Hypothesis& h : answer.hypotheses) sum += h.probability;
  EXPECT_LE(sum, 1);
}

TEST_F(LocalizationInARoom, IdenticalSegmentsGiveTheIdentityExactly) {
  auto one = std::make_shared<Map>();
  one->models.push_back(map->models[1]);
  test::changeView(*one, 0, [](View& view) { view.depth = {}; });
  const Localization answer = GlobalLocalization(one).localize(*one->view(0));
  ASSERT_FALSE(answer.hypotheses.empty());
  EXPECT_THAT(answer.hypotheses[0].T_m_c.T, PoseNear(Eigen::Isometry3d::Identity(), 1e-9, 1e-7));
}

// ---- nothing to answer

TEST(GlobalLocalization, AnEmptyMapOrViewHasAReason) {
  const View view = viewFrom(test::largeRoom(), loop()[0], 1);
  Localization answer = GlobalLocalization(std::make_shared<Map>()).localize(view);
  EXPECT_TRUE(answer.hypotheses.empty());
  EXPECT_THAT(answer.reason, HasSubstr("map has no local model"));
  const auto map = mapOf(test::largeRoom(), {loop()[0]});
  answer = GlobalLocalization(map).localize({});
  EXPECT_TRUE(answer.hypotheses.empty());
  EXPECT_THAT(answer.reason, HasSubstr("no planar segment"));
  map->models[0].setView(View());  // a model of an image that showed nothing
  answer = GlobalLocalization(map).localize(view);
  EXPECT_TRUE(answer.hypotheses.empty());
  EXPECT_NE(answer.reason, "");
}

class Degenerate : public testing::Test {
protected:
  // The reason why an image of a scene is not found in a map of another image of it.
  static std::string reasonFor(const test::Scene& scene, const Eigen::Isometry3d& model,
                               const Eigen::Isometry3d& query) {
    const Localization answer = GlobalLocalization(mapOf(scene, {model})).localize(viewFrom(scene, query, 1));
    EXPECT_TRUE(answer.hypotheses.empty());
    return answer.reason;
  }
};

TEST_F(Degenerate, ASingleWallGivesNoHypothesis) {
  const test::Scene wall{endlessPlane({0, 2, 0}, {0, 1, 0})};
  const std::string reason =
      reasonFor(wall, lookingAlong({0, 0, 1}, {0, 1, 0}), lookingAlong({0.2, 0.1, 1}, {0.1, 1, 0}));
  EXPECT_THAT(reason, HasSubstr("translation along"));
  EXPECT_THAT(reason, HasSubstr("rotation about"));
}

TEST_F(Degenerate, AFloorAndAWallGiveNoHypothesis) {
  const test::Scene scene{endlessPlane({0, 0, 0}, {0, 0, 1}), endlessPlane({0, 3, 0}, {0, 1, 0})};
  const std::string reason = reasonFor(scene, lookingAlong({0, 0, 1.2}, {0, 1, -0.3}),
                                       lookingAlong({0.3, 0.2, 1.2}, {0.1, 1, -0.3}));
  EXPECT_THAT(reason, HasSubstr("translation along"));
}

TEST_F(Degenerate, ACorridorWithoutEndGivesNoHypothesisAndNamesItsDirection) {
  const std::string reason = reasonFor(test::endlessCorridor(), lookingAlong({0, 0, 1.2}, {0, 1, -0.15}),
                                       lookingAlong({0.1, 0.4, 1.2}, {0.05, 1, -0.15}));
  EXPECT_THAT(reason, HasSubstr("translation along"));
}

TEST_F(Degenerate, AViewThatNoModelKnowsHasAReason) {
  const test::Scene small = test::box({0, 0, 0}, {2, 2.2, 2}), large = test::box({0, 0, 0}, {7, 6.5, 4});
  auto map = mapOf(large, {lookingAlong({3, 3, 1.8}, {1, 0.8, -0.5})});
  map->camera.mounting = CameraMounting{0.98, 10};  // a narrow prior in height and tilt
  GlobalLocalizationParams params;
  params.prior.rotation_std_deg = 5, params.prior.translation_std = 0.1;
  const View view = viewFrom(small, lookingAlong({0.6, 0.6, 1}, {1, 0.9, -0.5}), 1);
  const Localization answer = GlobalLocalization(map, params).localize(mounted(view, *map->camera.mounting));
  EXPECT_TRUE(answer.camera.sameMounting());
  EXPECT_TRUE(answer.hypotheses.empty());
  EXPECT_NE(answer.reason, "");
}

}  // namespace
}  // namespace facetloc
