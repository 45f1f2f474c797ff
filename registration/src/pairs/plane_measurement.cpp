// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/plane_measurement.h"

#include "pairs/cholesky3.h"

#include <Eigen/Cholesky>

#include <cmath>
#include <limits>

namespace facetloc::internal {
namespace {

// A stretch of half length a has the variance a^2 / 3 about its middle. Two of them overlap as long as their
// middles are no more than 2 a apart, uniformly: a variance of 4 a^2 / 3, twice the sum of both.
constexpr double kOfOverlapping = 2;

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

}  // namespace facetloc::internal
