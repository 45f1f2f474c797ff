// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/joint_refinement.h"

#include "pairs/cholesky3.h"
#include "pairs/plane_measurement.h"

#include <facetloc/features/pose.h>

#include <algorithm>
#include <cmath>

namespace facetloc::internal {
namespace {

constexpr int kCollections = 2;                         // how often the pairs are collected
constexpr int kIterations = 10;                         // Gauss-Newton steps per collection
constexpr double kConverged = 1e-6;                     // norm of a step [rad, m]
constexpr double kHuber2 = chiSquareQuantile(3, 0.99);  // square of the Huber threshold on d (METHOD 7)
constexpr double kMinCosine = 0.9;                      // between the normals of a pair at the hypothesis
constexpr double kInformationCap = 2.0;  // limit for a model segment, relative to its most informative pair

// For each scene segment the model segment that fits best, if any does.
std::vector<SegmentPair> collectPairs(const std::vector<Segment>& scene, const std::vector<Segment>& model,
                                      const PoseWithCovariance& pose, const MatchingParams& matching,
                                      const std::vector<SegmentPair>* chosen) {
  const auto counts = [chosen](int i, int k) {
    return !chosen || std::any_of(chosen->begin(), chosen->end(),
                                  [=](const SegmentPair& p) { return p.scene == i && p.model == k; });
  };
  std::vector<SegmentPair> pairs;
  for (std::size_t i = 0; i < scene.size(); ++i) {
    SegmentPair best{static_cast<int>(i), -1, matching.coplanarity_gate};
    for (std::size_t k = 0; k < model.size(); ++k) {
      const double distance = coplanarityDistance(scene[i], model[k], pose, best.distance, kMinCosine);
      if (distance >= best.distance ||
          !(overlapDistance(scene[i], model[k], pose, matching.overlap_gate) <= matching.overlap_gate))
        continue;
      if (!counts(best.scene, static_cast<int>(k))) continue;
      best.model = static_cast<int>(k);
      best.distance = distance;
    }
    if (best.model >= 0) pairs.push_back(best);
  }
  return pairs;
}

bool samePairs(const std::vector<SegmentPair>& a, const std::vector<SegmentPair>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const SegmentPair& p, const SegmentPair& q) {
    return p.scene == q.scene && p.model == q.model;
  });
}

// Quadratic model of the cost about a pose: information and gradient by a left, decoupled perturbation.
struct NormalEquations {
  Matrix6d A = Matrix6d::Zero();
  Vector6d g = Vector6d::Zero();

  void addPrior(const PoseWithCovariance& prior, const Matrix6d& prior_information,
                const Eigen::Isometry3d& T) {
    const Vector6d e = boxminus(T, prior.T);
    Matrix6d G = Matrix6d::Identity();  // de / d(perturbation)
    G.topLeftCorner<3, 3>() = leftJacobianSO3(e.head<3>()).inverse();
    const Matrix6d GtI = G.transpose() * prior_information;
    A += GtI * G;
    g += GtI * e;
  }
  void addPair(const Segment& scene, const Segment& model, const Eigen::Isometry3d& T, double share) {
    PlaneMeasurement m;
    if (!measurePlane(scene, model, T, 0.0, m)) return;
    Cholesky3 W;
    if (!W.compute(m.W)) return;
    const double d2 = W.squaredMahalanobis(m.h);
    const double weight = share * (d2 <= kHuber2 ? 1.0 : std::sqrt(kHuber2 / d2));
    const Matrix36d WiH = W.solve(m.H);
    A += weight * m.H.transpose() * WiH;
    g += weight * WiH.transpose() * m.h;
  }
  void addExtent(const Segment& scene, const Segment& model, const Eigen::Isometry3d& T, double share) {
    const ExtentMeasurement m = measureExtent(scene, model, T);
    const Eigen::LLT<Eigen::Matrix2d> W(m.W);
    if (W.info() != Eigen::Success) return;
    A += share * m.H.transpose() * W.solve(m.H);
    g += share * m.H.transpose() * W.solve(m.h);
  }
  void addConstraint(const TranslationConstraint& c, const Eigen::Isometry3d& T) {
    const double information = 1 / (c.std * c.std);
    A.bottomRightCorner<3, 3>() += information * c.direction * c.direction.transpose();
    g.tail<3>() += information * c.direction * (c.direction.dot(T.translation()) - c.value);
  }
};

}  // namespace

bool refineJointly(const std::vector<Segment>& scene, const std::vector<Segment>& model,
                   const PoseWithCovariance& prior, const MatchingParams& matching,
                   const std::optional<TranslationConstraint>& constraint, Hypothesis& hypothesis,
                   const std::vector<SegmentPair>* chosen, bool extents) {
  const Eigen::LLT<Matrix6d> prior_factor(prior.P);
  if (prior_factor.info() != Eigen::Success) return false;
  const Matrix6d prior_information = prior_factor.solve(Matrix6d::Identity());
  Hypothesis h = hypothesis;
  for (int collection = 0; collection < kCollections; ++collection) {
    std::vector<SegmentPair> pairs = collectPairs(scene, model, h.T_m_c, matching, chosen);
    if (pairs.empty()) return false;
    if (collection > 0 && samePairs(pairs, h.pairs)) break;
    std::vector<int> partners(model.size(), 0);
    for (const SegmentPair& p : pairs) ++partners[p.model];
    for (int i = 0; i < kIterations; ++i) {
      NormalEquations n;
      n.addPrior(prior, prior_information, h.T_m_c.T);
      for (const SegmentPair& p : pairs) {
        const double share = std::min(1.0, kInformationCap / partners[p.model]);
        n.addPair(scene[p.scene], model[p.model], h.T_m_c.T, share);
        if (extents) n.addExtent(scene[p.scene], model[p.model], h.T_m_c.T, share);
      }
      if (constraint) n.addConstraint(*constraint, h.T_m_c.T);
      const Eigen::LDLT<Matrix6d> solver(n.A);
      if (solver.info() != Eigen::Success || !solver.isPositive()) return false;
      const Vector6d step = -solver.solve(n.g);
      if (!step.allFinite()) return false;
      h.T_m_c.T = boxplus(h.T_m_c.T, step);
      h.T_m_c.P = solver.solve(Matrix6d::Identity());
      if (step.norm() < kConverged) break;
    }
    h.pairs = std::move(pairs);
  }
  hypothesis = std::move(h);
  return true;
}

}  // namespace facetloc::internal
