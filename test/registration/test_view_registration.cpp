// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/view_registration.h"
#include "ranking/global_localization.h"

#include <facetloc/features/pose.h>
#include <facetloc/registration/pose_prior.h>
#include <facetloc/testing/decimal_comma.h>
#include <facetloc/testing/map_of_view.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/random_segments.h>
#include <facetloc/testing/synthetic_views.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace facetloc {
namespace {

using namespace internal;
using test::lookingAlong, test::mounted, test::PoseNear, test::rectangle, test::Rng, test::viewFrom,
    testing::HasSubstr, testing::Not;

PoseWithCovariance isotropicPrior() { return {Eigen::Isometry3d::Identity(), posePrior({})}; }

const Eigen::Isometry3d kModelPose = lookingAlong({1.2, 1, 1.2}, {1, 1, -0.25});
const Eigen::Isometry3d kScenePose = lookingAlong({1.5, 1.3, 1.25}, {1.2, 1, -0.2});

class TwoViewsOfARoom : public testing::Test {
protected:
  std::vector<Hypothesis> align(const ViewRegistrationParams& params = {}) const {
    return ViewRegistration(params).align(Query(scene, isotropicPrior()), model);
  }
  const View model = viewFrom(test::largeRoom(), kModelPose, 1),
             scene = viewFrom(test::largeRoom(), kScenePose, 2);
  const Eigen::Isometry3d truth = kModelPose.inverse() * kScenePose;
};

TEST_F(TwoViewsOfARoom, AreRegistered) {
  const std::vector<Hypothesis> h = align();
  ASSERT_FALSE(h.empty());
  EXPECT_THAT(h[0].T_m_c.T, PoseNear(truth, 0.02, 0.4));
  EXPECT_FALSE(h[0].depth_assisted);
  EXPECT_GE(h[0].pairs.size(), 3u);
  EXPECT_GT(h[0].free_space, -20) << "a share of some 2 % contradicts";
  const Vector6d e = boxminus(truth, h[0].T_m_c.T);
  EXPECT_LT(e.dot(h[0].T_m_c.P.llt().solve(e)), chiSquareQuantile(6, 0.999));
}

TEST_F(TwoViewsOfARoom, HypothesesComeByScoreAndScoresAddUp) {
  const std::vector<Hypothesis> h = align();
  for (std::size_t i = 0; i < h.size(); ++i) {
    if (i > 0) {
      EXPECT_LE(h[i].score, h[i - 1].score);
    }
    EXPECT_NEAR(h[i].score, h[i].consensus + h[i].free_space, 1e-9);
    EXPECT_EQ(h[i].probability, 0);
    EXPECT_FALSE(h[i].T_w_c);
  }
}

TEST_F(TwoViewsOfARoom, NextToAStartThePoseIsThatOfTheSearch) {
  const Vector6d std =
      (Vector6d() << Eigen::Vector3d::Constant(3 * kDegree), Eigen::Vector3d::Constant(0.2)).finished();
  const auto from = [&](const Vector6d& off) {
    return ViewRegistration().alignFrom({boxplus(truth, off), std.cwiseAbs2().asDiagonal()}, Query(scene),
                                        model);
  };
  const std::vector<Hypothesis> searched = align();
  ASSERT_FALSE(searched.empty());
  Rng rng(5);
  for (int i = 0; i < 20; ++i) {
    const auto h = from(0.5 * std.cwiseProduct(test::gaussian<6>(rng)));
    ASSERT_TRUE(h);
    EXPECT_THAT(h->T_m_c.T, PoseNear(truth, 0.03, 0.6)) << i;
    EXPECT_THAT(h->T_m_c.T, PoseNear(searched[0].T_m_c.T, 0.02, 0.4)) << i;
    EXPECT_NEAR(h->score, h->consensus + h->free_space, 1e-9);
    EXPECT_NEAR(h->score, searched[0].score, 0.2 * searched[0].score) << "from fewer pixels";
  }
  // Somewhere else little agrees, and where the room is behind the camera nothing.
  const auto elsewhere = from((Vector6d() << 0, 0.6, 0, 1, 0, 0).finished());
  EXPECT_TRUE(!elsewhere || elsewhere->score < 0.5 * searched[0].score);
  EXPECT_FALSE(from((Vector6d() << 0, 3, 0, 0, 0, -30).finished()));
}

TEST_F(TwoViewsOfARoom, StartingNearTheTruthGivesTheSameAnswerWithFewerTrials) {
  const PoseWithCovariance prior = isotropicPrior();
  const std::vector<Hypothesis> everywhere = align();
  ASSERT_FALSE(everywhere.empty());
  const Vector6d std =
      (Vector6d() << Eigen::Vector3d::Constant(3 * kDegree), Eigen::Vector3d::Constant(0.2)).finished();
  const auto from = [&](const Eigen::Isometry3d& T_m_c) {
    return ViewRegistration().align(Query(scene, prior), model, {T_m_c, std.cwiseAbs2().asDiagonal()});
  };
  const Vector6d off = (Vector6d() << 0.03, -0.04, 0.02, 0.1, -0.05, 0.15).finished();
  const std::vector<Hypothesis> near = from(boxplus(truth, off));
  ASSERT_FALSE(near.empty());
  EXPECT_THAT(near[0].T_m_c.T, PoseNear(everywhere[0].T_m_c.T, 1e-3, 0.05));
  // The start is no measurement: all information about the pose comes from the pairs.
  EXPECT_NEAR(near[0].T_m_c.P.trace(), everywhere[0].T_m_c.P.trace(), 0.1 * everywhere[0].T_m_c.P.trace());
  EXPECT_LE(near.size(), everywhere.size());
  Eigen::Isometry3d away = truth;
  away.translation() += Eigen::Vector3d(1.5, 0, 1.5);
  for (const Hypothesis& h : from(away)) EXPECT_LT(h.score, near[0].score - 10);
}

TEST_F(TwoViewsOfARoom, TheSwappedViewsGiveTheInversePose) {
  const std::vector<Hypothesis> there = align(),
                                back = ViewRegistration().align(Query(model, isotropicPrior()), scene);
  ASSERT_FALSE(there.empty() || back.empty());
  EXPECT_THAT(back[0].T_m_c.T, PoseNear(there[0].T_m_c.T.inverse(), 0.02, 0.3));
}

TEST_F(TwoViewsOfARoom, EveryStepCanBeSwitchedOff) {
  const auto expectFound = [&](const ViewRegistrationParams& p, const char* what) {
    const std::vector<Hypothesis> h = align(p);
    ASSERT_FALSE(h.empty()) << what;
    EXPECT_THAT(h[0].T_m_c.T, PoseNear(truth, 0.1, 1.5)) << what;
  };
  ViewRegistrationParams p;
  p.steps.joint_refinement = false;
  expectFound(p, "no joint refinement");
  p = {};
  p.steps.depth_assistance = false;
  expectFound(p, "no depth assistance");
  p = {};
  p.score.by_overlap = true;
  expectFound(p, "score by overlap");
  p = {};
  p.calibration.score.free_space_weight = 0;
  expectFound(p, "no free space");
  EXPECT_EQ(align(p)[0].free_space, 0);
  p = {};
  p.ekf.iterations = 1;
  EXPECT_NO_THROW(align(p));
}

TEST_F(TwoViewsOfARoom, HypothesesMoveWithTheFrameOfTheModel) {
  View flat_scene = scene, flat_model = model;
  flat_scene.depth = flat_model.depth = {};
  const ViewRegistration registration;
  const std::vector<Hypothesis> here = registration.align(Query(flat_scene, isotropicPrior()), flat_model);
  ASSERT_FALSE(here.empty());
  Rng rng(1);
  for (int i = 0; i < 5; ++i) {
    const Eigen::Isometry3d X = test::randomPose(rng, 3, 5);
    View moved = flat_model;
    for (Segment& s : moved.segments) s = transformed(s, X);
    PoseWithCovariance prior = isotropicPrior();
    prior.T = X * prior.T;
    const std::vector<Hypothesis> there = registration.align(Query(flat_scene, prior), moved);
    ASSERT_EQ(there.size(), here.size());
    for (std::size_t k = 0; k < here.size(); ++k) {
      EXPECT_THAT(there[k].T_m_c.T, PoseNear(X * here[k].T_m_c.T, 1e-7, 1e-6));
      EXPECT_NEAR(there[k].score, here[k].score, 1e-8 * (1 + std::abs(here[k].score)));
    }
  }
}

TEST_F(TwoViewsOfARoom, HypothesesMoveWithTheAxesOfTheCamera) {
  View flat_scene = scene, flat_model = model;
  flat_scene.depth = flat_model.depth = {};
  const ViewRegistration registration;
  const std::vector<Hypothesis> here = registration.align(Query(flat_scene, isotropicPrior()), flat_model);
  Rng rng(2);
  for (int i = 0; i < 5; ++i) {
    const Eigen::Isometry3d Y(test::randomRotation(rng));
    View turned = flat_scene;
    for (Segment& s : turned.segments) s = transformed(s, Y);
    PoseWithCovariance prior = isotropicPrior();
    prior.T = prior.T * Y.inverse();
    const std::vector<Hypothesis> there = registration.align(Query(turned, prior), flat_model);
    ASSERT_EQ(there.size(), here.size());
    for (std::size_t k = 0; k < here.size(); ++k) {
      EXPECT_THAT(there[k].T_m_c.T, PoseNear(here[k].T_m_c.T * Y.inverse(), 1e-7, 1e-6));
      EXPECT_NEAR(there[k].score, here[k].score, 1e-8 * (1 + std::abs(here[k].score)));
    }
  }
}

TEST_F(TwoViewsOfARoom, AViewIsRegisteredWithItselfAtTheIdentity) {
  const std::vector<Hypothesis> h = ViewRegistration().align(Query(model, isotropicPrior()), model);
  ASSERT_FALSE(h.empty());
  EXPECT_THAT(h[0].T_m_c.T, PoseNear(Eigen::Isometry3d::Identity(), 1e-9, 1e-7));
  EXPECT_EQ(h[0].free_space, 0);
}

TEST_F(TwoViewsOfARoom, EmptyViewsHaveNoHypothesis) {
  const ViewRegistration registration;
  const View nothing;
  EXPECT_TRUE(registration.align(Query(nothing, isotropicPrior()), model).empty());
  EXPECT_TRUE(registration.align(Query(scene, isotropicPrior()), nothing).empty());
  EXPECT_TRUE(registration.align(Query(nothing, isotropicPrior()), nothing).empty());
}

TEST_F(TwoViewsOfARoom, NoTwoHypothesesAreTheSame) {
  const std::vector<Hypothesis> h = align();
  for (std::size_t i = 0; i < h.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      const Vector6d e = boxminus(h[i].T_m_c.T, h[k].T_m_c.T);
      EXPECT_TRUE(e.head<3>().norm() > 2 * kDegree || e.tail<3>().norm() > 0.1);
    }
}

// ---- depth-assisted poses

class Corridor : public testing::Test {
protected:
  // The camera of the model looks along the corridor, the scene's stands so far ahead of it and is
  // turned a little.
  static Eigen::Isometry3d modelPose() { return lookingAlong({0, 0, 1.2}, {0, 1, -0.15}); }
  static Eigen::Isometry3d scenePose(double ahead) {
    return lookingAlong({0.1, ahead, 1.2}, {0.05, 1, -0.15});
  }

  static std::vector<Hypothesis> align(const test::Scene& scene, double ahead,
                                       const ViewRegistrationParams& params = {}) {
    const View view = wallsOnly(viewFrom(scene, scenePose(ahead), 2, 12), scenePose(ahead)),
               model = wallsOnly(viewFrom(scene, modelPose(), 1, 12), modelPose());
    return ViewRegistration(params).align(Query(view, isotropicPrior()), model);
  }
  // Floor, ceiling and the long walls; all else shows in the depth picture alone.
  static View wallsOnly(View view, const Eigen::Isometry3d& T_w_c) {
    const auto isOther = [&](const Segment& s) {
      const Eigen::Vector3d centroid = T_w_c * s.t;
      return std::abs(s.normal().z()) > 0.5 ||
             (std::abs(centroid.x()) < 0.8 && std::abs(centroid.z() - 1.2) < 1.1);
    };
    auto& s = view.segments;
    s.erase(std::remove_if(s.begin(), s.end(), isOther), s.end());
    return view;
  }
};

TEST_F(Corridor, DepthFixesThePositionThatThePlanesLeaveFree) {
  const test::Scene scene = test::endlessCorridor() + test::box({0.4, 3, 0}, {0.9, 3.4, 1.2});
  for (const double ahead : {-0.4, 0.0, 0.35, 0.8}) {
    const std::vector<Hypothesis> h = align(scene, ahead);
    ASSERT_FALSE(h.empty()) << ahead;
    EXPECT_TRUE(h[0].depth_assisted);
    EXPECT_THAT(h[0].T_m_c.T, PoseNear(modelPose().inverse() * scenePose(ahead), 0.06, 0.5)) << ahead;
    const Eigen::Vector3d along = modelPose().linear().transpose() * Eigen::Vector3d::UnitY();
    EXPECT_LE(std::sqrt(along.dot(h[0].T_m_c.P.bottomRightCorner<3, 3>() * along)), 0.031);
  }
  ViewRegistrationParams params;
  params.steps.depth_assistance = false;
  EXPECT_TRUE(align(scene, 0.35, params).empty());
}

TEST_F(Corridor, WithoutReliefAlongItNoPositionIsInvented) {
  for (const double ahead : {0.0, 0.3, -0.6})
    EXPECT_TRUE(align(test::endlessCorridor(), ahead).empty()) << ahead;
}

// ---- a robot's camera

TEST_F(TwoViewsOfARoom, ThatPairsAloneRegisterNeedNothingElse) {
  PoseWithCovariance prior;
  const CameraMounting mounting{1.2, 10};
  prior.P = posePrior(mounting);
  const ViewRegistration registration;
  const std::vector<Hypothesis> alone = registration.align(Query(scene, prior), model),
                                known = registration.align(Query(scene, prior, floorInformation(mounting)),
                                                           model);
  ASSERT_FALSE(alone.empty());
  ASSERT_EQ(alone.size(), known.size());
  for (std::size_t i = 0; i < alone.size(); ++i)
    EXPECT_EQ(alone[i].T_m_c.T.matrix(), known[i].T_m_c.T.matrix());
}

class RobotBeforeAWall : public testing::Test {
protected:
  static constexpr double kHeight = 1.0;
  static constexpr CameraMounting kOnRobot{kHeight, 0};
  static Eigen::Isometry3d poseAt(double along, double turn) {
    return lookingAlong({along, 0, kHeight}, {turn, 1, 0});
  }
  // The wall fills both views. Everything else shows in the depth pictures alone.
  static View modelOf(const test::Scene& scene) { return wallOnly(viewFrom(scene, poseAt(0, 0), 1)); }
  static View viewOf(const test::Scene& scene, double along) {
    return wallOnly(viewFrom(scene, poseAt(along, 0.05), 2));
  }
  static std::vector<Hypothesis> align(const test::Scene& scene, double along, bool on_floor) {
    PoseWithCovariance prior{Eigen::Isometry3d::Identity(), posePrior(kOnRobot)};
    const Matrix6d known = on_floor ? floorInformation(kOnRobot) : Matrix6d(Matrix6d::Zero());
    const View view = viewOf(scene, along);
    return ViewRegistration().align(Query(view, prior, known), modelOf(scene));
  }
  // The same as global localization does it, in a map of nothing but that view.
  static std::vector<Hypothesis> localize(const test::Scene& scene, double along, bool on_floor) {
    Map map = test::mapOf(modelOf(scene));
    map.camera.mounting = kOnRobot;
    map.models[0].T_w_m.reset();  // hypotheses as they are, without evidence
    GlobalLocalizationParams params;
    params.steps.floor_information = on_floor;
    return GlobalLocalization(unowned(map), params)
        .localize(mounted(viewOf(scene, along), kOnRobot))
        .hypotheses;
  }
  static View wallOnly(View view) {
    auto& s = view.segments;
    const auto isOther = [](const Segment& x) { return x.normal().z() < 0.9 || x.normal().dot(x.t) > 1.65; };
    s.erase(std::remove_if(s.begin(), s.end(), isOther), s.end());
    return view;
  }
  const test::Scene wall = test::box({-20, 1.5, -10}, {20, 2, 10});
};

TEST_F(RobotBeforeAWall, IsFoundByOtherSurfaces) {
  const test::Scene scene = test::box({-20, 1.5, -10}, {-0.3, 2, 10}) +  // a door in a recess
                            test::box({0.6, 1.5, -10}, {20, 2, 10}) +
                            test::box({-0.3, 1.8, -10}, {0.6, 2, 10});
  for (const double along : {-0.25, 0.1, 0.3}) {
    EXPECT_TRUE(align(scene, along, false).empty());
    EXPECT_TRUE(localize(scene, along, false).empty());
    const Eigen::Isometry3d truth = poseAt(0, 0).inverse() * poseAt(along, 0.05);
    const auto isFound = [&](const std::vector<Hypothesis>& h) {
      return std::any_of(h.begin(), h.end(), [&](const Hypothesis& x) {
        return x.depth_assisted && isNear(x.T_m_c.T, truth, 0.06, 2);
      });
    };
    EXPECT_TRUE(isFound(align(scene, along, true))) << along;
    EXPECT_TRUE(isFound(localize(scene, along, true))) << along;
  }
}

TEST_F(RobotBeforeAWall, HasNoPositionAlongABareOne) {
  for (const double along : {-0.25, 0.1, 0.3}) {
    EXPECT_TRUE(align(wall, along, true).empty());
    EXPECT_TRUE(localize(wall, along, true).empty());
  }
}

// ---- reasons

std::string freeDirections(const std::vector<Segment>& segments, const Matrix6d& known = Matrix6d::Zero()) {
  View view;
  view.segments = segments;
  HypothesisTreeParams params;
  params.complete_rotation_deg = 3, params.complete_translation = 0.2;
  return unconstrainedDirections(Query(view, {}, known), params);
}

const std::vector<Segment> kCorridor{rectangle({0, 1, 3}, {0, 1, 0}, 1, 0.8),
                                     rectangle({1, 0, 3}, {1, 0, 0}, 1, 0.9)};
const std::vector<Segment> kCorner{kCorridor[0], kCorridor[1], rectangle({0, 0, 4}, {0, 0, 1}, 0.8, 0.8)};

// The planes of a noisier camera fix a pose less well, whichever they are.
TEST(UnconstrainedDirections, AreJudgedByTheNoiseOfTheView) {
  std::vector<Segment> corner = kCorner;
  for (Segment& s : corner) s.Sigma_q = Eigen::Vector3d(0.08, 0.08, 0.08).cwiseAbs2().asDiagonal();
  const auto reasonAt = [&](double noise) {
    View view;
    view.segments = corner, view.depth.noise.inverse_depth_std *= noise;
    return unconstrainedDirections(Query(view, {}, Matrix6d::Zero()), HypothesisTreeParams());
  };
  EXPECT_NE(reasonAt(1), "");
  EXPECT_EQ(reasonAt(1.2), reasonAt(1)) << "as images of a Kinect may have";
  EXPECT_EQ(reasonAt(3), "");
}

TEST_F(TwoViewsOfARoom, MayFixAPoseWhereItDoes) {
  const ViewRegistration registration;
  for (std::size_t n = 0; n <= scene.segments.size(); ++n) {
    View some = scene;
    some.segments.resize(n);
    const bool found = !registration.align(Query(some, isotropicPrior()), model).empty();
    EXPECT_TRUE(registration.mayFixPose(Query(some)) || !found) << n << " segments";
  }
  EXPECT_TRUE(registration.mayFixPose(Query(scene)));
  const View nothing;
  EXPECT_FALSE(registration.mayFixPose(Query(nothing)));
  View one = scene;
  one.segments.resize(1);
  EXPECT_FALSE(registration.mayFixPose(Query(one)));
}

TEST(UnconstrainedDirections, OfARoomCornerAreEmpty) { EXPECT_EQ(freeDirections(kCorner), ""); }

TEST(UnconstrainedDirections, OfACorridorIsTheTranslationAlongIt) {
  EXPECT_EQ(freeDirections(kCorridor), "translation along (0.00, 0.00, 1.00)");
}

TEST(UnconstrainedDirections, DoNotDependOnTheLocale) {
  const test::DecimalComma comma;
  EXPECT_EQ(freeDirections(kCorridor), "translation along (0.00, 0.00, 1.00)");
}

TEST(UnconstrainedDirections, OfOneWallAreTwoTranslationsAndARotation) {
  const std::string text = freeDirections({rectangle({0, 0, 3}, {0, 0, 1}, 1, 0.8)});
  EXPECT_THAT(text, HasSubstr("rotation about (0.00, 0.00, 1.00)"));
  EXPECT_THAT(text, HasSubstr("translation along"));
  EXPECT_NE(text.find("translation along"), text.rfind("translation along"));
  EXPECT_THAT(text, Not(HasSubstr("-0.00")));
}

TEST(UnconstrainedDirections, OfAWallBeforeARobotIsTheTranslationAlongIt) {
  const std::vector<Segment> wall{rectangle({0, 0, 3}, {0, 0, -1}, 1, 0.8)};
  EXPECT_EQ(freeDirections(wall, floorInformation(CameraMounting{1, 0})),
            "translation along (1.00, 0.00, 0.00)");
}

TEST(UnconstrainedDirections, WithoutPlanesAreAllSix) {
  const std::string text = freeDirections({});
  int commas = 0;
  for (std::size_t at = text.find("), "); at != std::string::npos; at = text.find("), ", at + 1)) ++commas;
  EXPECT_EQ(commas, 5);
}

}  // namespace
}  // namespace facetloc
