// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/pair_distance.h"

#include "pairs/cholesky3.h"
#include "pairs/plane_measurement.h"

#include <facetloc/registration/candidate_pairs.h>

#include <algorithm>
#include <limits>

namespace facetloc {
namespace internal {
namespace {

// Shapes count as their 50 % ellipse while the pose is gated at 99 %: chi2(3) quantiles (METHOD 4.2).
constexpr double kShape = 2.366 / 11.34;

// Shape of a segment as a flat covariance with its offset uncertainty across, in the frame that its axes R
// are given in.
Eigen::Matrix3d shapeCovariance(const Segment& s, const Eigen::Matrix3d& R) {
  const Eigen::Vector3d variances(kShape * s.lambda[0], kShape * s.lambda[1], s.Sigma_q(2, 2));
  return R * variances.asDiagonal() * R.transpose();
}

// d^T (shape covariance) d, for d given in the segment's axes.
double shapeVariance(const Segment& s, const Eigen::Vector3d& d) {
  return kShape * (s.lambda[0] * d.x() * d.x() + s.lambda[1] * d.y() * d.y()) +
         s.Sigma_q(2, 2) * d.z() * d.z();
}

}  // namespace

double coplanarityDistance(const Segment& scene, const Segment& model, const PoseWithCovariance& T_m_c,
                           double gate, double min_cosine) {
  constexpr double kTooFar = std::numeric_limits<double>::infinity();
  if (!((T_m_c.T.linear() * scene.normal()).dot(model.normal()) > min_cosine)) return kTooFar;
  if (offsetDistance(scene, model, T_m_c) > gate) return kTooFar;
  PlaneMeasurement m;
  if (!measurePlane(scene, model, T_m_c.T, min_cosine, m)) return kTooFar;
  return innovationDistance(m, T_m_c.P);
}

double overlapDistance(const Segment& scene, const Segment& model, const PoseWithCovariance& T_m_c,
                       double gate) {
  const Eigen::Matrix3d R = T_m_c.T.linear();
  const Eigen::Vector3d moved = R * scene.t;
  const Eigen::Vector3d delta = moved + T_m_c.T.translation() - model.t;
  const Matrix6d& P = T_m_c.P;
  // Bound by Cauchy and Schwarz, d^T S^-1 d >= (d^T d)^2 / d^T S d, which rejects most pairs without S.
  Vector6d J;
  J << moved.cross(delta), delta;
  const double variance = J.dot(P * J) + shapeVariance(scene, scene.R.transpose() * (R.transpose() * delta)) +
                          shapeVariance(model, model.R.transpose() * delta);
  const double bound = delta.squaredNorm() * delta.squaredNorm() / variance;
  if (bound > gate) return bound;

  const Eigen::Matrix3d K = -skew(moved);  // d delta / d phi; d delta / d t = I
  const Eigen::Matrix3d cross = K * P.topRightCorner<3, 3>();
  Eigen::Matrix3d S =
      K * P.topLeftCorner<3, 3>() * K.transpose() + cross + cross.transpose() + P.bottomRightCorner<3, 3>();
  S += shapeCovariance(scene, R * scene.R) + shapeCovariance(model, model.R);  // METHOD 4.2
  Cholesky3 cholesky;
  return cholesky.compute(S) ? cholesky.squaredMahalanobis(delta) : std::numeric_limits<double>::infinity();
}

}  // namespace internal

std::vector<SegmentPair> candidatePairs(const std::vector<Segment>& scene, const std::vector<Segment>& model,
                                        const PoseWithCovariance& prior, const MatchingParams& params) {
  std::vector<SegmentPair> pairs;
  const int n = std::min<int>(scene.size(), params.max_segments),
            m = std::min<int>(model.size(), params.max_segments);
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < m; ++k) {
      const double distance =
          internal::coplanarityDistance(scene[i], model[k], prior, params.coplanarity_gate);
      if (!(distance <= params.coplanarity_gate)) continue;
      if (!(internal::overlapDistance(scene[i], model[k], prior, params.overlap_gate) <= params.overlap_gate))
        continue;
      pairs.push_back({i, k, distance});
    }
  std::stable_sort(pairs.begin(), pairs.end(), [](const SegmentPair& a, const SegmentPair& b) {
    return a.scene + a.model < b.scene + b.model;  // METHOD 4.3
  });
  return pairs;
}

}  // namespace facetloc
