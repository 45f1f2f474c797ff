// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/plane_measurement.h"

#include "pairs/cholesky3.h"

#include <facetloc/registration/candidate_pairs.h>

#include <Eigen/Cholesky>

#include <algorithm>
#include <limits>

namespace facetloc {
namespace internal {
namespace {

// A stretch of half length a has the variance a^2 / 3 about its middle. Two of them overlap as long as their
// middles are no more than 2 a apart, uniformly: a variance of 4 a^2 / 3, twice the sum of both.
constexpr double kOfOverlapping = 2;

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

bool measurePlane(const Segment& F, const Segment& Fp, const Eigen::Isometry3d& T_m_c, double min_cosine,
                  PlaneMeasurement& out) {
  // At q = q' = 0: n(0) = e_z, D(0) = [e_x e_y], E' = -I.
  const Eigen::Matrix3d R = T_m_c.linear();
  const Eigen::Vector3d u = R * F.R.col(2);
  if (!(u.dot(Fp.R.col(2)) > min_cosine)) return false;
  const Eigen::Vector3d x = Fp.R.col(0), y = Fp.R.col(1);
  const Eigen::Vector3d lever = Fp.t - T_m_c.translation();
  const Eigen::Vector3d delta = R * F.t - lever;
  out.h << x.dot(u), y.dot(u), u.dot(delta);
  out.H.row(0) << u.cross(x).transpose(), 0, 0, 0;
  out.H.row(1) << u.cross(y).transpose(), 0, 0, 0;
  out.H.row(2) << lever.cross(u).transpose(), u.transpose();
  const Eigen::Vector3d gx = R * F.R.col(0), gy = R * F.R.col(1);
  Eigen::Matrix3d E;
  E << x.dot(gx), x.dot(gy), 0, y.dot(gx), y.dot(gy), 0, delta.dot(gx), delta.dot(gy), 1;
  out.W = E * F.Sigma_q * E.transpose() + Fp.Sigma_q;
  return true;
}

double offsetDistance(const Segment& F, const Segment& Fp, const PoseWithCovariance& T_m_c, double slack) {
  const Eigen::Matrix3d R = T_m_c.T.linear();
  const Eigen::Vector3d u = R * F.R.col(2);
  const Eigen::Vector3d lever = Fp.t - T_m_c.T.translation();
  const Eigen::Vector3d delta = R * F.t - lever;
  Vector6d H;  // third row of the Jacobian, and of E below
  H << lever.cross(u), u;
  const Eigen::Vector3d back = R.transpose() * delta;
  const Eigen::Vector3d e(back.dot(F.R.col(0)), back.dot(F.R.col(1)), 1);
  const double variance = H.dot(T_m_c.P * H) + e.dot(F.Sigma_q * e) + Fp.Sigma_q(2, 2) + slack * slack;
  const double h = u.dot(delta);
  return h * h / variance;
}

double innovationDistance(const PlaneMeasurement& m, const Matrix6d& P) {
  const Eigen::Matrix3d S = m.H * P * m.H.transpose() + m.W;
  Cholesky3 cholesky;
  return cholesky.compute(S) ? cholesky.squaredMahalanobis(m.h) : std::numeric_limits<double>::infinity();
}

ExtentMeasurement measureExtent(const Segment& scene, const Segment& model, const Eigen::Isometry3d& T_m_c) {
  const Eigen::Vector3d moved = T_m_c.linear() * scene.t;
  const Eigen::Matrix<double, 3, 2> axes = model.R.leftCols<2>(),
                                    scene_axes = T_m_c.linear() * scene.R.leftCols<2>();
  ExtentMeasurement m;
  m.h = axes.transpose() * (moved + T_m_c.translation() - model.t);
  m.H << -axes.transpose() * skew(moved), axes.transpose();
  const Eigen::Matrix2d turned = axes.transpose() * scene_axes;
  m.W = kOfOverlapping * turned * scene.lambda.asDiagonal() * turned.transpose();
  m.W.diagonal() += kOfOverlapping * model.lambda;
  return m;
}

Matrix6d informationOf(const ExtentMeasurement& m) {
  const Eigen::LLT<Eigen::Matrix2d> W(m.W);
  if (W.info() != Eigen::Success) return Matrix6d::Zero();
  return m.H.transpose() * W.solve(m.H);
}

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

using namespace internal;

std::vector<SegmentPair> candidatePairs(const std::vector<Segment>& scene, const std::vector<Segment>& model,
                                        const PoseWithCovariance& prior, const MatchingParams& params) {
  std::vector<SegmentPair> pairs;
  const int n = std::min<int>(scene.size(), params.max_segments),
            m = std::min<int>(model.size(), params.max_segments);
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < m; ++k) {
      const double distance = coplanarityDistance(scene[i], model[k], prior, params.coplanarity_gate);
      if (!(distance <= params.coplanarity_gate)) continue;
      if (!(overlapDistance(scene[i], model[k], prior, params.overlap_gate) <= params.overlap_gate)) continue;
      pairs.push_back({i, k, distance});
    }
  std::stable_sort(pairs.begin(), pairs.end(), [](const SegmentPair& a, const SegmentPair& b) {
    return a.scene + a.model < b.scene + b.model;  // METHOD 4.3
  });
  return pairs;
}

}  // namespace facetloc
