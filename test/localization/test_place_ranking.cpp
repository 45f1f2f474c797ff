// SPDX-License-Identifier: BSD-3-Clause
#include "ranking/place_ranking.h"

#include <facetloc/features/pose.h>
#include <facetloc/testing/changed_views.h>
#include <facetloc/testing/synthetic_depth.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace facetloc {
namespace {

using namespace internal;
using test::lookingAlong;

Hypothesis hypothesis(double score, const std::optional<Eigen::Isometry3d>& T_w_c = {}, int model = 0) {
  Hypothesis h;
  h.score = h.consensus = score;
  h.T_w_c = T_w_c, h.model = model;
  return h;
}

constexpr ProbabilityParams kEven;  // the map lacks a place as likely as it holds it

Eigen::Isometry3d pose(double x, double turn_deg = 0) {
  return Eigen::Translation3d(x, 0, 0) * Eigen::Isometry3d(expSO3({0, turn_deg * kDegree, 0}));
}

void rankPlaces(const MergingParams& params, std::vector<Hypothesis>& h) {
  const PlainProbabilityCalibration plain;
  mergePlaces(params, h);
  assignProbabilities(plain.slope, plain.null_score, h);
}

TEST(RankPlaces, ProbabilitiesAreTheSoftmaxWithANullPlace) {
  constexpr double kSlope = 0.11, kNullScore = 17;
  std::vector<Hypothesis> h{hypothesis(20, pose(0)), hypothesis(35, pose(1)), hypothesis(28, pose(2))};
  mergePlaces({}, h);
  assignProbabilities(kSlope, kNullScore, h);
  double sum = std::exp(kSlope * kNullScore);
  for (const double score : {35, 28, 20}) sum += std::exp(kSlope * score);
  ASSERT_EQ(h.size(), 3u);
  const double scores[] = {35, 28, 20};
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(h[i].score, scores[i]);
    EXPECT_NEAR(h[i].probability, std::exp(kSlope * scores[i]) / sum, 1e-12);
  }
}

TEST(RankPlaces, ProbabilitiesSumToLessThanOneForAnyScores) {
  for (const double score : {-1e6, -10.0, 0.0, 27.0, 500.0, 1e6}) {
    std::vector<Hypothesis> h{hypothesis(score, pose(0)), hypothesis(score - 1, pose(1)),
                              hypothesis(-score, pose(2))};
    rankPlaces({}, h);
    double sum = 0;
    for (const Hypothesis& x : h) {
      EXPECT_TRUE(x.probability >= 0 && x.probability <= 1);
      sum += x.probability;
    }
    EXPECT_LE(sum, 1 + 1e-12);
  }
}

TEST(RankPlaces, APlaceAtTheNullScoreIsAsLikelyAsNone) {
  std::vector<Hypothesis> h{hypothesis(-12, pose(0))};
  assignProbabilities(0.1, -12, h);
  EXPECT_NEAR(h[0].probability, 0.5, 1e-12);
}

TEST(RankPlaces, APoseCloseToABetterOneIsTheSameAnswer) {
  std::vector<Hypothesis> h{hypothesis(10, pose(0)), hypothesis(9, pose(0.29)), hypothesis(8, pose(0.31)),
                            hypothesis(-5, pose(0.29))};
  assignProbabilities(0.1, 0, h);
  const double sum = 1 + std::exp(1) + std::exp(0.9) + std::exp(0.8) + std::exp(-0.5);
  EXPECT_NEAR(h[0].probability, (std::exp(1) + std::exp(0.9) + std::exp(-0.5)) / sum, 1e-12);
  EXPECT_EQ(h[1].probability, 0);
  EXPECT_NEAR(h[2].probability, std::exp(0.8) / sum, 1e-12) << "too far from the first";
  EXPECT_EQ(h[3].probability, 0) << "the best of those that it is close to has it";
}

TEST(RankPlaces, TheHigherTheRunnersUpScoreTheLikelierIsNoPlaceOfTheList) {
  ProbabilityCalibration params;
  params.null_score = 10, params.runners_up = 3, params.runners_up_weight = 0.5;
  params.least_null_score = -15, params.ambiguity_weight = 0;
  const auto null = [&params](const std::vector<Hypothesis>& sorted) {
    return nullScore(params, kEven, {}, sorted);
  };
  std::vector<Hypothesis> h{hypothesis(50, pose(0))};
  EXPECT_EQ(null({}), -15);
  EXPECT_EQ(null(h), -15);
  h.push_back(hypothesis(20, pose(1)));
  EXPECT_DOUBLE_EQ(null(h), 20);
  h.push_back(hypothesis(-10, pose(2)));
  h.push_back(hypothesis(-40, pose(3)));
  EXPECT_DOUBLE_EQ(null(h), 5);
  h.push_back(hypothesis(-1000, pose(4)));
  EXPECT_DOUBLE_EQ(null(h), 5) << "of the best three only";
  h[0].score = 60;
  EXPECT_DOUBLE_EQ(null(h), 5) << "whatever the best one scores";
  h = {hypothesis(-20, pose(0)), hypothesis(-80, pose(1))};
  EXPECT_EQ(null(h), -15) << "the best of hopeless ones is hopeless too";
}

TEST(RankPlaces, AmbiguousMapsMoreLikelyLackTheRightPlace) {
  ProbabilityCalibration params;
  params.least_null_score = -15, params.ambiguity_weight = 0.5, params.usual_ambiguity = 10;
  EXPECT_DOUBLE_EQ(nullScore(params, kEven, {}, {}), -15 + 0.5 * 10);
  EXPECT_DOUBLE_EQ(nullScore(params, kEven, MapAmbiguity{40, 20}, {}), -15 + 0.5 * 25)
      << "few views, and the usual";
  EXPECT_NEAR(nullScore(params, kEven, MapAmbiguity{40, 1000000}, {}), -15 + 0.5 * 40, 1e-3);
}

/** Where the map's own views show that wrong places score low, little is needed to be sure. */
TEST(RankPlaces, DistinctMapsAreBelievedSooner) {
  ProbabilityCalibration params;
  params.least_null_score = -15, params.usual_ambiguity = 10, params.distinct_weight = 0.5;
  params.distinct_views = 5, params.distinct_scale = 30, params.slope = 0.1;
  const MapAmbiguity distinct{-80, 10};  // with the usual: (10 * -80 + 5 * 10) / 15 = -50
  EXPECT_DOUBLE_EQ(nullScore(params, kEven, distinct, {}), -15 + 0.5 * -50);
  const ProbabilityParams mostly{0.9};
  EXPECT_NEAR(nullScore(params, mostly, distinct, {}) - nullScore(params, kEven, distinct, {}),
              std::log(9) / (0.1 * std::exp(50.0 / 30)), 1e-9)
      << "beta grows by exp(-A / distinct_scale)";
}

/** Prior odds of the map holding the place or not are the odds of the answer, all else equal. */
TEST(RankPlaces, AMapThatIsKnownToBeCompleteIsBelievedMore) {
  const ProbabilityCalibration params;
  const auto odds = [&](double incomplete) {
    std::vector<Hypothesis> h{hypothesis(10)};
    assignProbabilities(params.slope, nullScore(params, ProbabilityParams{incomplete}, {}, h), h);
    return h[0].probability / (1 - h[0].probability);
  };
  EXPECT_NEAR(odds(0.1) / odds(0.5), 9, 1e-9);
  EXPECT_NEAR(odds(0.75) / odds(0.5), 1.0 / 3, 1e-9);
}

TEST(RankPlaces, PriorOddsAreThoseOfTheMapLackingThePlace) {
  EXPECT_EQ(kEven.priorLogOdds(), 0);
  EXPECT_NEAR(ProbabilityParams{0.9}.priorLogOdds(), std::log(9), 1e-12);
  EXPECT_NEAR(ProbabilityParams{0.1}.priorLogOdds(), -std::log(9), 1e-12);
}

TEST(RankPlaces, HypothesesOfOnePlaceBecomeTheBestOfThem) {
  std::vector<Hypothesis> h{hypothesis(10, pose(0), 1), hypothesis(30, pose(0.14, 1.9), 2),
                            hypothesis(20, pose(0, 2.1), 3), hypothesis(25, pose(0.16), 4)};
  rankPlaces({}, h);
  // 25 lies 0.02 m and 1.9 deg from 30 and is absorbed; so are 10 and 20, the latter within 0.14 m and 0.2
  // deg.
  ASSERT_EQ(h.size(), 1u);
  EXPECT_EQ(h[0].model, 2);

  h = {hypothesis(30, pose(0)), hypothesis(20, pose(0.151)), hypothesis(10, pose(0, 2.01)),
       hypothesis(5, pose(0.149, 1.99))};
  rankPlaces({}, h);
  ASSERT_EQ(h.size(), 3u);
  EXPECT_EQ(h[2].score, 10);

  MergingParams apart;
  apart.enabled = false;
  h = {hypothesis(30, pose(0)), hypothesis(20, pose(0))};
  rankPlaces(apart, h);
  EXPECT_EQ(h.size(), 2u);
}

TEST(RankPlaces, APlaceListsItsSupportingModels) {
  std::vector<Hypothesis> h{hypothesis(10, pose(0), 7), hypothesis(30, pose(0.1), 2),
                            hypothesis(20, pose(0), 7), hypothesis(25, pose(3), 4)};
  mergePlaces({}, h);
  ASSERT_EQ(h.size(), 2u);
  EXPECT_THAT(h[0].supporting_models, testing::ElementsAre(2, 7));  // each once
  EXPECT_THAT(h[1].supporting_models, testing::ElementsAre(4));
  h.push_back(hypothesis(5, pose(0.1), 4));
  h.push_back(hypothesis(40, pose(0.05), 9));
  mergePlaces({}, h);
  ASSERT_EQ(h.size(), 2u);
  EXPECT_THAT(h[0].supporting_models, testing::ElementsAre(2, 4, 7, 9));
}

TEST(RankPlaces, WithoutWorldPosesNothingIsMerged) {
  std::vector<Hypothesis> h{hypothesis(10), hypothesis(30), hypothesis(20, pose(0))};
  rankPlaces({}, h);
  EXPECT_EQ(h.size(), 3u);
  EXPECT_EQ(h[0].score, 30);
}

TEST(RankPlaces, EqualScoresKeepTheirOrder) {
  std::vector<Hypothesis> h;
  for (int i = 0; i < 20; ++i) h.push_back(hypothesis(i % 2, pose(i), i));
  rankPlaces({}, h);
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(h[i].model, 2 * i + 1);
    EXPECT_EQ(h[10 + i].model, 2 * i);
  }
}

TEST(RankPlaces, OfNoHypothesesIsEmpty) {
  std::vector<Hypothesis> h;
  rankPlaces({}, h);
  EXPECT_TRUE(h.empty());
}

// ---- evidence of the nearest local models

class Evidence : public testing::Test {
protected:
  Evidence() {
    for (const double x : {0.8, 1.3, 1.8}) {
      const Eigen::Isometry3d T_w_m = lookingAlong({x, 0.5, 1.2}, {0.4, 1, -0.2});
      map.models.emplace_back("", 0, T_w_m, viewFrom(T_w_m));
    }
  }
  static View viewFrom(const Eigen::Isometry3d& T_w_c) {
    View view;
    const DepthImage image = test::render(test::furnishedRoom(), test::smallCamera(), T_w_c).image;
    view.intrinsics = image.camera;
    view.depth = DepthPicture::fromDepth(image);
    return view;
  }
  /** Poses in the first local model, and their covariances. */
  void knowInModel(std::vector<Hypothesis>& h) const {
    for (Hypothesis& x : h) {
      x.T_m_c.T = map.models[0].T_w_m->inverse() * *x.T_w_c;
      x.T_m_c.P.diagonal() << Eigen::Vector3d::Constant(1e-4), Eigen::Vector3d::Constant(1e-3);
    }
  }
  PlaceRanking ranking() const { return PlaceRanking(unowned(map), params); }
  bool add(std::vector<Hypothesis>& h) const {
    PixelVerdicts nothing;
    return ranking().addEvidence(scene, h, nothing);
  }
  double evidenceFor(const Eigen::Isometry3d& pose) const {
    std::vector<Hypothesis> h{hypothesis(0, pose)};
    EXPECT_TRUE(add(h));
    return h[0].evidence;
  }
  void refinePlaces(std::vector<Hypothesis>& h) const {
    PixelVerdicts nothing;
    ranking().refinePlaces(scene, h, nothing);
  }

  Map map;
  const Eigen::Isometry3d truth = lookingAlong({1.5, 0.8, 1.2}, {0.3, 1, -0.2});
  const Eigen::Isometry3d elsewhere = Eigen::Translation3d(0.4, 0.3, 0) * truth;
  View scene = viewFrom(truth);
  GlobalLocalizationParams params;
};

TEST_F(Evidence, IsForTheTruePlaceAndAgainstAnother) {
  std::vector<Hypothesis> h{hypothesis(20, elsewhere), hypothesis(10, truth)};
  ASSERT_TRUE(add(h));
  EXPECT_LT(h[0].evidence, 0);  // sorted by the old scores
  EXPECT_GT(h[1].evidence, h[0].evidence + 30);
  EXPECT_DOUBLE_EQ(h[0].score, 20 + h[0].evidence);
  EXPECT_DOUBLE_EQ(h[1].score, 10 + h[1].evidence);
}

TEST_F(Evidence, APlaceThatLooksLikeNoOtherIsBelievedSooner) {
  const Hypothesis here = hypothesis(0, truth);
  params.calibration.probability.least_null_score = -10, params.calibration.probability.usual_ambiguity = 0;
  map.ambiguity = MapAmbiguity{40, 20};  // counts as much as the usual one
  const auto nullScoreWith = [&](double weight, double share) {
    params.calibration.sequence.lookalike_weight = weight;
    params.calibration.sequence.lookalike_share_of_place = share;
    return ranking().oddsOfKnown(true, here).null_score;
  };
  EXPECT_DOUBLE_EQ(nullScoreWith(0.8, 0.5), 0.2 * -10 + 0.8 * 20) << "this place has no scores";
  map.models[0].alias_score = 4, map.models[2].alias_score = 8;
  EXPECT_DOUBLE_EQ(nullScoreWith(0.8, 0.5), 0.2 * -10 + 0.8 * 14);
  EXPECT_DOUBLE_EQ(nullScoreWith(0.8, 0), 0.2 * -10 + 0.8 * 20);
  EXPECT_DOUBLE_EQ(nullScoreWith(1, 1), 8);
  for (LocalModel& model : map.models) model.alias_score = -50;
  EXPECT_DOUBLE_EQ(nullScoreWith(1, 1), -10) << "no less than any wrong place scores";
  map.models[1].alias_score = 90;
  EXPECT_DOUBLE_EQ(nullScoreWith(1, 1), 20) << "no more than the map's";
  map.models[1].T_w_m->translation().x() += 100;
  EXPECT_DOUBLE_EQ(nullScoreWith(1, 1), -10) << "far models do not belong to this place";
}

TEST_F(Evidence, ReplacesTheEvidenceOfTheirOwnModel) {
  std::vector<Hypothesis> h{hypothesis(20, truth)};
  h[0].free_space = -7;
  h[0].score = h[0].consensus + h[0].free_space;
  ASSERT_TRUE(add(h));
  EXPECT_DOUBLE_EQ(h[0].score, 20 + h[0].evidence);
}

TEST_F(Evidence, OfAMovedObjectIsBounded) {
  // A board at half the distance of all that is seen through a quarter of the image: it was not there before.
  const double before = evidenceFor(truth);
  DepthImage image = test::render(test::furnishedRoom(), test::smallCamera(), truth).image;
  for (int v = 0; v < image.camera.height / 2; ++v)
    for (int u = 0; u < image.camera.width / 2; ++u) image.depth[v * image.camera.width + u] *= 0.5f;
  scene.depth = DepthPicture::fromDepth(image);
  const double after = evidenceFor(truth);
  EXPECT_LT(after, before) << "what stands there may hide the map, but explains less of it";
  // Closed form, of a quarter of the pixels in each direction, as far as they are tested.
  constexpr double kQuarter = 0.25;
  const double largest = 2 * params.calibration.evidence.contradiction_weight *
                             std::log1p(kQuarter / params.calibration.score.free_space_share) +
                         params.calibration.evidence.disagreement_weight * kQuarter;
  EXPECT_GT(after, before - largest);
  EXPECT_LT(evidenceFor(elsewhere), after) << "elsewhere more than that contradicts";
}

TEST_F(Evidence, WeighsTheEvidenceOfAllNearModels) {
  std::vector<Hypothesis> h{hypothesis(0, truth)}, doubled = h;
  ASSERT_TRUE(add(h));
  params.calibration.evidence.contradiction_weight *= 2;
  params.calibration.evidence.occlusion_weight *= 2, params.calibration.evidence.disagreement_weight *= 2;
  ASSERT_TRUE(add(doubled));
  EXPECT_NEAR(doubled[0].evidence, 2 * h[0].evidence, 1e-9);
}

TEST_F(Evidence, TheBestPlaceIsBelievedByItsLeadOverTheNextOnes) {
  params.refinement.enabled = false;
  std::vector<Hypothesis> h{hypothesis(20, truth), hypothesis(20, elsewhere)};
  ranking().rank(scene, h);
  ASSERT_EQ(h.size(), 2u);
  const double null = nullScore(params.calibration.probability, params.probability, {}, h);
  const double none = 1 - h[0].probability - h[1].probability;
  EXPECT_NEAR(std::log(h[0].probability / none), params.calibration.probability.slope * (h[0].score - null),
              1e-6);
}

TEST_F(Evidence, AListThatGrowsIsRankedAsOneThatComesAtOnce) {
  Eigen::Isometry3d near = truth;
  near.translation().x() += 0.02;
  std::vector<Hypothesis> all{hypothesis(30, truth), hypothesis(20, elsewhere), hypothesis(28, near)};
  knowInModel(all);
  PixelVerdicts known;
  for (const std::size_t n : {1, 2, 3, 3}) {
    std::vector<Hypothesis> grown(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(n)), at_once = grown;
    ranking().rank(scene, grown, known);
    ranking().rank(scene, at_once);
    ASSERT_EQ(grown.size(), at_once.size());
    for (std::size_t i = 0; i < grown.size(); ++i) {
      EXPECT_EQ(grown[i].T_w_c->matrix(), at_once[i].T_w_c->matrix());
      EXPECT_EQ(grown[i].T_m_c.P, at_once[i].T_m_c.P);
      EXPECT_EQ(grown[i].score, at_once[i].score);
      EXPECT_EQ(grown[i].probability, at_once[i].probability);
      EXPECT_EQ(grown[i].coverage.agreeing, at_once[i].coverage.agreeing);
    }
  }
}

TEST_F(Evidence, HypothesesBeyondTheBestGetTheLeastOfThose) {
  params.evidence.hypotheses = 2;
  Eigen::Isometry3d near = truth;
  near.translation().x() += 0.02;
  std::vector<Hypothesis> h{hypothesis(30, truth), hypothesis(20, near), hypothesis(10, truth),
                            hypothesis(5)};
  ASSERT_TRUE(add(h));
  const double least = std::min(h[0].evidence, h[1].evidence);
  EXPECT_EQ(h[2].evidence, least);
  EXPECT_EQ(h[3].evidence, least);
}

TEST_F(Evidence, HopelessHypothesesGetTheLeastOfTheOthers) {
  const double hopeless =
      -std::log(params.calibration.evidence.hopeless_odds) / params.calibration.plain_probability.slope;
  const std::vector<Hypothesis> given{hypothesis(50, elsewhere), hypothesis(50 - hopeless + 0.1, truth),
                                      hypothesis(50 - hopeless - 0.1, truth)};
  std::vector<Hypothesis> h = given;
  ASSERT_TRUE(add(h));
  EXPECT_GT(h[1].evidence, h[0].evidence);
  EXPECT_EQ(h[2].evidence, h[0].evidence);
  params.calibration.evidence.hopeless_odds = 0;
  h = given;
  ASSERT_TRUE(add(h));
  EXPECT_EQ(h[2].evidence, h[1].evidence);
}

TEST_F(Evidence, OfAPerfectViewComesFromItsUntestedPixels) {
  // Closed form: no pixel contradicts, is hidden or disagrees; the rest is the share that came untested.
  map.models.resize(1);
  map.models[0].setView(scene);
  map.models[0].T_w_m = truth;
  std::vector<Hypothesis> h{hypothesis(0, truth)};
  ASSERT_TRUE(add(h));
  const double share = params.calibration.evidence.untested_pixels *
                       params.calibration.evidence.untested_contradiction /
                       (1 + params.calibration.evidence.untested_pixels);
  EXPECT_NEAR(h[0].evidence,
              -2 * params.calibration.evidence.contradiction_weight *
                  std::log1p(share / params.calibration.score.free_space_share),
              0.2);
}

TEST_F(Evidence, APoseThatNothingTestsGainsNothingByThat) {
  Eigen::Isometry3d away = truth;
  away.linear() = Eigen::AngleAxisd(60 * kDegree, Eigen::Vector3d::UnitZ()) * away.linear();
  Eigen::Isometry3d wrong = truth;
  wrong.translation() += Eigen::Vector3d(0.1, 0.1, 0);
  std::vector<Hypothesis> h{hypothesis(30, truth), hypothesis(20, away), hypothesis(10, wrong)};
  ASSERT_TRUE(add(h));
  EXPECT_LT(h[1].evidence, h[0].evidence - 20);
  EXPECT_LT(h[1].evidence, h[2].evidence + 20);
}

TEST_F(Evidence, APasserByInOneModelIsForgiven) {
  const double before = evidenceFor(truth);
  // Somebody stood half as far away in a third of the view when the model was made.
  DepthImage image = test::render(test::furnishedRoom(), test::smallCamera(), *map.models[1].T_w_m).image;
  for (int v = 0; v < image.camera.height; ++v)
    for (int u = 100; u < 200; ++u) image.depth[v * image.camera.width + u] *= 0.5f;
  test::changeView(map, 1, [&](View& view) { view.depth = DepthPicture::fromDepth(image); });
  const double after = evidenceFor(truth);
  EXPECT_LT(after, before);
  const double alone = params.calibration.evidence.contradiction_weight *
                       std::log1p(0.3 / params.calibration.score.free_space_share);
  EXPECT_GT(after, before - 0.5 * alone);
}

TEST_F(Evidence, RefinedPlacesAreNearerToTheTruth) {
  Eigen::Isometry3d near = truth;
  near.translation() += Eigen::Vector3d(0.03, -0.02, 0.02);
  Eigen::Isometry3d wrong = truth;
  wrong.translation() += Eigen::Vector3d(0.8, 0.5, 0);
  std::vector<Hypothesis> h{hypothesis(20, near), hypothesis(15, wrong)};
  knowInModel(h);
  ASSERT_TRUE(add(h));
  refinePlaces(h);
  ASSERT_EQ(h.size(), 2u);
  EXPECT_LT((h[0].T_w_c->translation() - truth.translation()).norm(), 0.005);
  EXPECT_TRUE((*map.models[0].T_w_m * h[0].T_m_c.T).isApprox(*h[0].T_w_c, 1e-12));
  EXPECT_GT(h[0].score, h[1].score + 30);
}

TEST_F(Evidence, HopelessPlacesAreNotRefined) {
  const double hopeless =
      -std::log(params.calibration.evidence.hopeless_odds) / params.calibration.probability.slope;
  Eigen::Isometry3d near = truth;
  near.translation() += Eigen::Vector3d(0.03, -0.02, 0.02);
  const auto refined = [&](double below) {
    std::vector<Hypothesis> h{hypothesis(50, lookingAlong({3, 3, 1.2}, {-1, 0, 0})),
                              hypothesis(50 - below, near)};
    knowInModel(h);
    refinePlaces(h);
    return std::none_of(h.begin(), h.end(),
                        [&](const Hypothesis& x) { return x.T_w_c->isApprox(near, 1e-12); });
  };
  EXPECT_TRUE(refined(hopeless - 0.1));
  EXPECT_FALSE(refined(hopeless + 0.1));
}

TEST_F(Evidence, APlaceThatSeveralModelsFindIsLikelier) {
  const auto scores = [&](std::vector<Hypothesis> h) {
    params.refinement.enabled = false;
    ranking().rank(scene, h);
    std::vector<double> of_place;
    for (const Hypothesis& x : h) {
      of_place.push_back(x.score - x.consensus - x.evidence);
      EXPECT_GT(x.probability, 0);
    }
    return of_place;
  };
  EXPECT_THAT(scores({hypothesis(20, truth, 0)}), testing::ElementsAre(0));
  EXPECT_THAT(scores({hypothesis(20, truth, 0), hypothesis(19, truth, 0)}), testing::ElementsAre(0));
  for (const int n : {2, 3}) {
    std::vector<Hypothesis> h;
    for (int model = 0; model < n; ++model) h.push_back(hypothesis(20, truth, model));
    EXPECT_THAT(scores(h), testing::ElementsAre(testing::DoubleNear(
                               params.calibration.evidence.support_weight * std::log(n), 1e-9)));
  }
}

TEST_F(Evidence, ModelsOfOnePoseFindAPlaceOnce) {
  for (int copies = 0; copies < 2; ++copies) map.models.push_back(map.models[0]);
  std::vector<Hypothesis> h{hypothesis(20, truth, 0), hypothesis(20, truth, 3), hypothesis(20, truth, 4),
                            hypothesis(20, truth, 1)};
  params.refinement.enabled = false;
  ranking().rank(scene, h);
  ASSERT_EQ(h.size(), 1u);
  EXPECT_EQ(h[0].supporting_models.size(), 4u);
  EXPECT_NEAR(h[0].score - h[0].consensus - h[0].evidence,
              params.calibration.evidence.support_weight * std::log(2), 1e-9);
}

TEST_F(Evidence, OfAHypothesisWithoutModelsIsZero) {
  Eigen::Isometry3d wrong = truth;
  wrong.translation().x() += 0.6;
  std::vector<Hypothesis> h{hypothesis(22, truth), hypothesis(21.5, wrong), hypothesis(21)};
  ranking().rank(scene, h);
  ASSERT_EQ(h.size(), 3u);
  const auto nowhere = std::find_if(h.begin(), h.end(), [](const Hypothesis& x) { return !x.T_w_c; });
  ASSERT_NE(nowhere, h.end());
  for (const Hypothesis& x : h) EXPECT_LE(nowhere->evidence, x.evidence);
}

TEST_F(Evidence, ARefinementThatLeavesItsPlaceIsNotTaken) {
  const auto refined = [&](double off) {
    Eigen::Isometry3d beside = truth;
    beside.translation() += Eigen::Vector3d(off, 0, 0);
    std::vector<Hypothesis> h{hypothesis(20, beside)};
    h[0].T_m_c.T = map.models[0].T_w_m->inverse() * beside;
    h[0].T_m_c.P.diagonal() << Eigen::Vector3d::Constant(1e-3), Eigen::Vector3d::Constant(0.1);
    EXPECT_TRUE(add(h));
    refinePlaces(h);
    return (h[0].T_w_c->translation() - truth.translation()).norm();
  };
  EXPECT_NEAR(refined(0.2), 0.2, 1e-12) << "the truth is in another place";
  EXPECT_LT(refined(0.14), 0.01);
}

TEST_F(Evidence, IsMissingWithoutPixelsToCompare) {
  const std::vector<Hypothesis> plain{hypothesis(20, truth)};
  const auto expectNone = [&](std::vector<Hypothesis> h) {
    EXPECT_FALSE(add(h));
    for (const Hypothesis& x : h) EXPECT_EQ(x.evidence, 0);
  };
  expectNone({});
  expectNone({hypothesis(20)});  // no world pose
  params.evidence.enabled = false;
  expectNone(plain);
  params.evidence.enabled = true;
  Eigen::Isometry3d far = truth;
  far.translation().x() += 50;  // no model looks there
  expectNone({hypothesis(20, far)});
  const View with_depth = scene;
  scene.depth = {};
  expectNone(plain);
  scene = with_depth;
  test::changeViews(map, [](View& view) { view.depth = {}; });
  expectNone(plain);
  map.models.clear();
  expectNone(plain);
}

}  // namespace
}  // namespace facetloc
