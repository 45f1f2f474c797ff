// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/ekf_pose_update.h"

#include "pairs/cholesky3.h"

#include <cmath>

namespace facetloc::internal {
namespace {

// A step of so much leaves an error of some 3e-5, a fiftieth of the least uncertainty of a plane's slope and
// offset.
constexpr double kSettledRotation = 1e-4;     // [rad]
constexpr double kSettledTranslation = 1e-4;  // [m]

// Linearisations after which the pace of the steps is known. An update that ends earlier is taken on trust;
// from here on, one that will not settle in time has no solution and is refused.
constexpr int kPaceKnown = 8;

// Steps shrink by about the same factor from one to the next. False if they cannot become small enough in the
// iterations that are left, going by the length of the last one and of the second before it.
bool maySettle(double length, double length_before, int iterations_left) {
  if (!(length < length_before)) return false;
  const double of_two = length / length_before;
  return length * std::pow(of_two, 0.5 * iterations_left) < kSettledTranslation;
}

// One linearisation of h about the displacement e from the prior mean.
struct Linearization {
  PlaneMeasurement m;
  Matrix36d Ht;                     // dh / de = H blkdiag(J_l(e_phi), I)
  Eigen::Matrix<double, 6, 3> PHt;  // P0 Ht^T
  Cholesky3 S;                      // factor of Ht P0 Ht^T + W
  Eigen::Vector3d v;                // -(S)^-1 (h - Ht e), so that the next e is P0 Ht^T v

  bool at(const Segment& scene, const Segment& model, const PoseWithCovariance& prior, const Vector6d& e,
          double min_cosine) {
    if (!measurePlane(scene, model, boxplus(prior.T, e), min_cosine, m)) return false;
    Ht = m.H;
    if (!e.isZero()) Ht.leftCols<3>() = m.H.leftCols<3>() * leftJacobianSO3(e.head<3>());
    PHt.noalias() = prior.P * Ht.transpose();
    const Eigen::Matrix3d innovation = Ht * PHt + m.W;
    if (!S.compute(innovation)) return false;
    v = -S.solve(Eigen::Vector3d(m.h - Ht * e));
    return true;
  }
};

}  // namespace

EkfUpdate ekfPoseUpdate(const Segment& scene, const Segment& model, const PoseWithCovariance& prior,
                        const EkfParams& params) {
  EkfUpdate out;
  Vector6d e = Vector6d::Zero(), step = Vector6d::Zero();
  Linearization lin;
  bool settled = false;
  double length[2] = {0, 0};  // lengths of the last two steps [rad + m]
  for (int i = 0; i < params.iterations && !settled; ++i) {
    e += step;
    if (!lin.at(scene, model, prior, e, params.min_cosine)) return out;
    step = lin.PHt * lin.v - e;  // METHOD 5.1
    const double turn = step.head<3>().norm(), shift = step.tail<3>().norm();
    settled = turn < kSettledRotation && shift < kSettledTranslation;
    if (!settled && i >= kPaceKnown && !maySettle(turn + shift, length[i % 2], params.iterations - 1 - i))
      return out;
    length[i % 2] = turn + shift;
  }
  Cholesky3 noise;
  if (!noise.compute(lin.m.W)) return out;
  const Eigen::Vector3d h = lin.m.h + lin.Ht * step;  // the residual that the last step leaves
  e += step;

  // METHOD 5.2: e^T P0^-1 e + h^T W^-1 h with e = P0 Ht^T v. For one iteration this is the paper's gate, h^T
  // S^-1 h.
  out.cost = lin.v.dot(lin.Ht * e) + noise.squaredMahalanobis(h);
  out.gain = 0.5 * (lin.S.logDeterminant() - noise.logDeterminant());  // METHOD 5.3
  if (!(out.cost <= params.gate)) return out;

  const Eigen::Matrix<double, 6, 3> K = lin.S.solve<6>(lin.PHt.transpose()).transpose();
  const Matrix6d IKH = Matrix6d::Identity() - K * lin.Ht;
  Matrix6d P = IKH * prior.P * IKH.transpose() + K * lin.m.W * K.transpose();  // Joseph form
  const Eigen::Matrix3d reset = leftJacobianSO3(e.head<3>());
  P.topRows<3>() = (reset * P.topRows<3>()).eval();
  P.leftCols<3>() = (P.leftCols<3>() * reset.transpose()).eval();
  out.pose.T = boxplus(prior.T, e);
  out.pose.P = 0.5 * (P + P.transpose());
  out.information = lin.m.H.transpose() * noise.solve<6>(lin.m.H);
  out.accepted = true;
  return out;
}

}  // namespace facetloc::internal
