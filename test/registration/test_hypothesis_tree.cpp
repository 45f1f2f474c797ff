// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/hypothesis_tree.h"

#include <facetloc/registration/candidate_pairs.h>
#include <facetloc/registration/pose_prior.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/random_segments.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace facetloc {
namespace {

using namespace internal;
using test::disturbed, test::gaussian, test::rectangle, test::Rng, test::uniform;

using PairSet = std::vector<std::pair<int, int>>;

PairSet setOf(const std::vector<SegmentPair>& pairs) {
  PairSet set;
  for (const SegmentPair& p : pairs) set.emplace_back(p.scene, p.model);
  return set;
}

PoseWithCovariance widePrior() {
  return {Eigen::Isometry3d::Identity(), posePrior(CameraMounting{0.98, 10})};
}

// A small scene with ambiguities: surfaces in three directions, some parallel and near each other.
struct Case {
  explicit Case(unsigned seed) {
    Rng rng(seed);
    prior = widePrior();
    truth = boxplus(prior.T, 0.5 * gaussian<6>(rng, prior.P));
    const Eigen::Vector3d normal[] = {{0, 0, 1}, {1, 0, 0.1}, {0, 1, 0}, {0, 0.05, 1}, {1, 0.1, 0.2}};
    for (const Eigen::Vector3d& n : normal) {
      const Eigen::Vector3d centre = 2 * n.normalized() + 0.4 * gaussian<3>(rng);
      const double half_x = uniform(rng, 0.4, 1.2), half_y = uniform(rng, 0.3, 0.4);
      const Segment s = rectangle(centre, n, half_x, half_y, uniform(rng, -3, 3), 0.01, 0.01);
      model.push_back(disturbed(s, gaussian<3>(rng, s.Sigma_q)));
      const Segment part = test::anotherPart(rng, s, 0.1);
      scene.push_back(transformed(disturbed(part, gaussian<3>(rng, s.Sigma_q)), truth.inverse()));
    }
    candidates = candidatePairs(scene, model, prior);
  }
  TreeSearchResult search(const HypothesisTreeParams& params) const {
    return searchHypotheses(scene, model, candidates, prior, {}, {}, params);
  }
  std::vector<Segment> scene, model;
  PoseWithCovariance prior;
  Eigen::Isometry3d truth;
  std::vector<SegmentPair> candidates;
};

HypothesisTreeParams exhaustive() {
  HypothesisTreeParams p;
  p.max_expansions = 1000000, p.max_hypotheses = 1000000, p.max_pairs = 4, p.min_gain = 0;
  p.angle_gate = 1e6;
  p.duplicate_rotation_deg = p.duplicate_translation = 0;
  return p;
}

// Every set of up to max_pairs candidates, replayed separately in the order of the list. A set is a node of
// the tree if no segment occurs twice and every one of its beginnings is a node that is not complete; it is
// emitted if it is complete itself. No queue, no siblings, no shared state.
struct BruteForce {
  BruteForce(const Case& c, const HypothesisTreeParams& params) {
    const int m = static_cast<int>(c.candidates.size());
    std::vector<int> chosen;
    const auto visit = [&](auto&& self, int first) -> void {
      if (!chosen.empty()) judge(c, params, chosen);
      if (static_cast<int>(chosen.size()) == params.max_pairs) return;
      for (int i = first; i < m; ++i) {
        chosen.push_back(i);
        self(self, i + 1);
        chosen.pop_back();
      }
    };
    visit(visit, 0);
  }
  void judge(const Case& c, const HypothesisTreeParams& params, const std::vector<int>& chosen) {
    std::set<int> scene, model;
    for (const int i : chosen)
      if (!scene.insert(c.candidates[i].scene).second || !model.insert(c.candidates[i].model).second) return;
    PoseWithCovariance pose = c.prior;
    Matrix6d information = Matrix6d::Zero();
    for (std::size_t k = 0; k < chosen.size(); ++k) {
      const Segment &F = c.scene[c.candidates[chosen[k]].scene], &Fp = c.model[c.candidates[chosen[k]].model];
      if (k > 0 && overlapDistance(F, Fp, pose) > MatchingParams{}.overlap_gate) return;
      if (k + 1 == chosen.size()) ++updates;
      const EkfUpdate u = ekfPoseUpdate(F, Fp, pose);
      if (!u.accepted || u.gain < params.min_gain) return;
      pose = u.pose;
      information += u.information;
      const bool complete = observability(information)
                                .within(params.complete_rotation_deg * kDegree, params.complete_translation);
      if (!complete) continue;
      if (k + 1 < chosen.size()) return;  // a complete beginning has no children
      PairSet set;
      for (const int i : chosen) set.emplace_back(c.candidates[i].scene, c.candidates[i].model);
      emitted.insert(set);
    }
  }
  std::set<PairSet> emitted;
  int updates = 0;  // nodes that the tree has to expand
};

TEST(HypothesisTree, WithoutLimitsEqualsBruteForceOverAllSubsets) {
  std::size_t hypotheses = 0;
  for (unsigned seed = 1; seed <= 8; ++seed)
    for (const double min_gain : {0.0, 0.5}) {
      const Case c(seed);
      ASSERT_LE(c.candidates.size(), 25u);
      HypothesisTreeParams params = exhaustive();
      params.min_gain = min_gain;
      const BruteForce want(c, params);
      const TreeSearchResult got = c.search(params);
      std::set<PairSet> emitted;
      for (const PoseNode& node : got.by_pairs.complete)
        EXPECT_TRUE(emitted.insert(setOf(node.pairs)).second) << "a set was emitted twice";
      EXPECT_EQ(emitted, want.emitted) << "seed " << seed;
      EXPECT_EQ(got.expansions, want.updates) << "seed " << seed;
      hypotheses += emitted.size();
    }
  EXPECT_GT(hypotheses, 50u);
}

TEST(HypothesisTree, FindsTheTruePose) {
  int found = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const Case c(seed);
    const TreeSearchResult result = c.search({});
    found += std::any_of(result.by_pairs.complete.begin(), result.by_pairs.complete.end(),
                         [&c](const PoseNode& n) {
                           const Vector6d e = boxminus(n.pose.T, c.truth);
                           return e.head<3>().norm() < 3 * kDegree && e.tail<3>().norm() < 0.15;
                         });
  }
  EXPECT_GE(found, 36);
}

TEST(HypothesisTree, PairFilterLosesNoConsistentHypothesis) {
  // The angles between two segments do not depend on the pose; with its gate wide open and at three standard
  // deviations the true pairs survive.
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Case c(seed);
    HypothesisTreeParams open = exhaustive(), gated = exhaustive();
    gated.angle_gate = 3;
    std::set<PairSet> all, kept;
    for (const PoseNode& n : c.search(open).by_pairs.complete) all.insert(setOf(n.pairs));
    for (const PoseNode& n : c.search(gated).by_pairs.complete) kept.insert(setOf(n.pairs));
    EXPECT_FALSE(all.empty());
    EXPECT_EQ(all, kept);
    EXPECT_LE(c.search(gated).expansions, c.search(open).expansions);
  }
}

TEST(HypothesisTree, AHypothesisUsesEverySegmentOnce) {
  for (unsigned seed = 1; seed <= 10; ++seed)
    for (const PoseNode& node : Case(seed).search(exhaustive()).by_pairs.complete) {
      std::set<int> scene, model;
      for (const SegmentPair& p : node.pairs) {
        EXPECT_TRUE(scene.insert(p.scene).second);
        EXPECT_TRUE(model.insert(p.model).second);
      }
      EXPECT_TRUE(observability(node.information).within(3 * kDegree, 0.2));
    }
}

TEST(HypothesisTree, DuplicatesAreSuppressed) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const Case c(seed);
    HypothesisTreeParams params = exhaustive();
    const std::size_t all = c.search(params).by_pairs.complete.size();
    params.duplicate_rotation_deg = 1, params.duplicate_translation = 0.05;
    const std::vector<PoseNode> distinct = c.search(params).by_pairs.complete;
    EXPECT_LE(distinct.size(), all);
    for (std::size_t i = 0; i < distinct.size(); ++i)
      for (std::size_t k = 0; k < i; ++k) {
        const Vector6d e = boxminus(distinct[i].pose.T, distinct[k].pose.T);
        EXPECT_TRUE(e.head<3>().norm() > 1 * kDegree || e.tail<3>().norm() > 0.05);
      }
  }
}

TEST(HypothesisTree, LimitsAreKept) {
  const Case c(3);
  HypothesisTreeParams params = exhaustive();
  const TreeSearchResult all = c.search(params);
  ASSERT_GT(all.expansions, 20);
  params.max_expansions = 10;
  EXPECT_EQ(c.search(params).expansions, 10);
  params = exhaustive();
  params.max_hypotheses = 1;
  const TreeSearchResult one = c.search(params);
  ASSERT_EQ(one.by_pairs.complete.size(), 1u);
  EXPECT_EQ(setOf(one.by_pairs.complete[0].pairs),
            setOf(all.by_pairs.complete[0].pairs));  // the best-ranked first
  params = exhaustive();
  params.max_pairs = 2;
  for (const PoseNode& n : c.search(params).by_pairs.complete) EXPECT_LE(n.pairs.size(), 2u);
  for (const PoseNode& n : c.search(params).by_pairs.incomplete) EXPECT_LE(n.pairs.size(), 2u);
}

TEST(HypothesisTree, AGainThresholdPrunes) {
  const Case c(3);
  HypothesisTreeParams params = exhaustive();
  const int all = c.search(params).expansions;
  params.min_gain = 3;
  EXPECT_LT(c.search(params).expansions, all);
  params.min_gain = 100;
  EXPECT_TRUE(c.search(params).by_pairs.complete.empty());
}

TEST(HypothesisTree, OneFreeTranslationIsReportedWithItsDirection) {
  // Floor and two side walls of a corridor along z: nothing fixes z.
  std::vector<Segment> corridor{rectangle({0, 1, 3}, {0, 1, 0}, 2, 0.8),
                                rectangle({1, 0, 3}, {1, 0, 0}, 2, 0.9),
                                rectangle({-1, 0, 3}, {-1, 0, 0}, 2, 0.9)};
  const PoseWithCovariance prior = widePrior();
  const TreeSearchResult result =
      searchHypotheses(corridor, corridor, candidatePairs(corridor, corridor, prior), prior, {}, {}, {});
  EXPECT_TRUE(result.by_pairs.complete.empty());
  ASSERT_FALSE(result.by_pairs.incomplete.empty());
  for (const PoseNode& n : result.by_pairs.incomplete) {
    EXPECT_NEAR(n.free_direction.norm(), 1, 1e-9);
    EXPECT_GT(std::abs(n.free_direction.z()), 0.99);
    EXPECT_TRUE(observability(n.information).oneTranslationFree(3 * kDegree, 0.2));
  }
}

TEST(HypothesisTree, APriorThatFixesAPoseNeedsNoPairs) {
  // Two walls of a corner; roll, pitch and height are known.
  const std::vector<Segment> corner{rectangle({0, 0, 3}, {0, 0, -1}, 2, 0.8),
                                    rectangle({1, 0, 2}, {-1, 0, 0}, 2, 0.9)};
  const PoseWithCovariance prior = widePrior();
  const auto pairs = candidatePairs(corner, corner, prior);
  const auto search = [&](const Matrix6d& known) {
    return searchHypotheses(corner, corner, pairs, prior, {}, {}, {}, known);
  };
  EXPECT_TRUE(search(Matrix6d::Zero()).with_known.complete.empty());
  const Matrix6d floor = floorInformation(CameraMounting{1, 0});
  EXPECT_FALSE(search(floor).with_known.complete.empty());
  for (const PoseNode& n : search(floor).with_known.complete) EXPECT_EQ(n.pairs.size(), 2u);
}

TEST(HypothesisTree, WithoutCandidatesIsEmpty) {
  const TreeSearchResult result = searchHypotheses({}, {}, {}, widePrior(), {}, {}, {});
  EXPECT_TRUE(result.by_pairs.complete.empty());
  EXPECT_TRUE(result.by_pairs.incomplete.empty());
  EXPECT_EQ(result.expansions, 0);
}

TEST(HypothesisTree, ManyCandidatesFillMoreThanOneWord) {
  // 12 parallel-free segments against themselves under a prior that allows everything: hundreds of
  // candidates.
  Rng rng(5);
  std::vector<Segment> segments;
  for (int i = 0; i < 14; ++i) segments.push_back(test::randomSegment(rng));
  PoseWithCovariance prior;
  prior.P.diagonal() << 1, 1, 1, 4, 4, 4;
  const std::vector<SegmentPair> candidates = candidatePairs(segments, segments, prior);
  ASSERT_GT(candidates.size(), 64u);
  HypothesisTreeParams params = exhaustive();
  params.max_pairs = 2;
  const TreeSearchResult result = searchHypotheses(segments, segments, candidates, prior, {}, {}, params);
  // The roots are all expanded, and with them every compatible pair that overlaps.
  int want = 0;
  for (std::size_t a = 0; a < candidates.size(); ++a) {
    ++want;
    const SegmentPair& p = candidates[a];
    const EkfUpdate u = ekfPoseUpdate(segments[p.scene], segments[p.model], prior);
    if (!u.accepted || observability(u.information).within(3 * kDegree, 0.2)) continue;
    for (std::size_t b = a + 1; b < candidates.size(); ++b) {
      const SegmentPair& q = candidates[b];
      if (p.scene == q.scene || p.model == q.model) continue;
      want += overlapDistance(segments[q.scene], segments[q.model], u.pose) <= MatchingParams{}.overlap_gate;
    }
  }
  EXPECT_EQ(result.expansions, want);
}

TEST(Observability, WithoutInformationIsTheWeakPrior) {
  const PrincipalStd o = observability(Matrix6d::Zero());
  EXPECT_NEAR(o.rotation[2], 30 * kDegree, 1e-9);
  EXPECT_NEAR(o.translation[0], 10, 1e-9);
  EXPECT_FALSE(o.within(3 * kDegree, 0.2));
}

TEST(Observability, OrdersTheTranslationsAndNamesTheirDirections) {
  Matrix6d information = Matrix6d::Zero();
  information.topLeftCorner<3, 3>() = 1e6 * Eigen::Matrix3d::Identity();
  information.diagonal().tail<3>() << 100, 0, 1e4;  // x to 0.1 m, y not at all, z to 1 cm
  const PrincipalStd o = observability(information);
  EXPECT_NEAR(o.translation[0], 0.01, 1e-4);
  EXPECT_NEAR(o.translation[1], 0.1, 1e-3);
  EXPECT_NEAR(o.translation[2], 10, 1e-3);
  EXPECT_NEAR(std::abs(o.translation_axes.col(2).y()), 1, 1e-9);
  EXPECT_NEAR(std::abs(o.translation_axes.col(0).z()), 1, 1e-9);
  EXPECT_FALSE(o.within(3 * kDegree, 0.2));
  EXPECT_TRUE(o.oneTranslationFree(3 * kDegree, 0.2));
  EXPECT_FALSE(o.oneTranslationFree(3 * kDegree, 0.05));  // then two are free
  EXPECT_TRUE(o.within(3 * kDegree, 11));
}

TEST(Observability, IsTheSpreadOfTheInverseForRealInformation) {
  // One to six planes with offsets known to millimetres: information from 0.01 to 1e7 in one matrix.
  Rng rng(9);
  double worst_below_a_metre = 0, worst = 0;
  const auto compare = [&](double got, double want) {
    const double error = std::abs(got / want - 1);
    worst = std::max(worst, error);
    if (want < 1) worst_below_a_metre = std::max(worst_below_a_metre, error);
  };
  for (int i = 0; i < 2000; ++i) {
    Matrix6d information = Matrix6d::Zero();
    for (int k = 0; k <= i % 6; ++k) {
      Segment s = test::randomSegment(rng);
      s.Sigma_q = test::randomCovariance<3>(rng, {0.003, 0.003, 0.002});
      information += ekfPoseUpdate(s, s, widePrior()).information;
    }
    Matrix6d Lambda = information;
    Lambda.diagonal().head<3>().array() += std::pow(30 * kDegree, -2);
    Lambda.diagonal().tail<3>().array() += 0.01;
    using Precise = Eigen::Matrix<long double, 6, 6>;
    const Matrix6d P = Precise(Lambda.cast<long double>()).inverse().cast<double>();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> rotation(P.topLeftCorner<3, 3>()),
        translation(P.bottomRightCorner<3, 3>());
    const PrincipalStd o = observability(information);
    for (int k = 0; k < 3; ++k) {
      compare(o.rotation[k], std::sqrt(rotation.eigenvalues()[k]));
      compare(o.translation[k], std::sqrt(translation.eigenvalues()[k]));
    }
    const Eigen::Vector3d free = o.translation_axes.col(2);
    EXPECT_NEAR(free.norm(), 1, 1e-6);
    EXPECT_GT(free.dot(P.bottomRightCorner<3, 3>() * free), 0.98 * translation.eigenvalues()[2]);
  }
  // Where a decision is made, the closed form is exact enough; of free motions, only the size
  // matters.
  EXPECT_LT(worst_below_a_metre, 1e-3);
  EXPECT_LT(worst, 0.2);
}

}  // namespace
}  // namespace facetloc
