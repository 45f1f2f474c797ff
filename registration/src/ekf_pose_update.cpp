// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/registration/ekf_pose_update.h>

namespace facetloc {
namespace {

constexpr double kConvergedRotation = 1e-5;     // [rad]
constexpr double kConvergedTranslation = 1e-5;  // [m]

// One linearisation of h about the displacement e from the prior mean.
struct Linearization {
  PlaneMeasurement m;
  Matrix36d Ht;                     // dh / de = H blkdiag(J_l(e_phi), I)
  Eigen::Matrix<double, 6, 3> PHt;  // P0 Ht^T
  Eigen::LLT<Eigen::Matrix3d> S;    // of Ht P0 Ht^T + W
  Eigen::Vector3d v;                // -(S)^-1 (h - Ht e), so that the next e is P0 Ht^T v

  bool at(const Segment& scene, const Segment& model, const PoseWithCovariance& prior, const Vector6d& e,
          double min_cosine) {
    if (!measurePlane(scene, model, perturbed(prior.T, e), min_cosine, m)) return false;
    Ht = m.H;
    if (!e.isZero()) Ht.leftCols<3>() = m.H.leftCols<3>() * leftJacobianSO3(e.head<3>());
    PHt.noalias() = prior.P * Ht.transpose();
    const Eigen::Matrix3d innovation = Ht * PHt + m.W;
    S.compute(innovation);
    if (S.info() != Eigen::Success) return false;
    v = -S.solve(m.h - Ht * e);
    return true;
  }
};

double logDeterminant(const Eigen::LLT<Eigen::Matrix3d>& llt) {
  return 2 * llt.matrixLLT().diagonal().array().log().sum();
}

}  // namespace

EkfUpdate ekfPoseUpdate(const Segment& scene, const Segment& model, const PoseWithCovariance& prior,
                        const EkfParams& params) {
  EkfUpdate out;
  Vector6d e = Vector6d::Zero();
  Linearization lin;
  bool converged = params.iterations == 1;
  for (int i = 0; i < params.iterations; ++i) {
    if (!lin.at(scene, model, prior, e, params.min_cosine)) return out;
    const Vector6d next = lin.PHt * lin.v;  // Eq. (8.1) of METHOD
    const double rotation_change = (next - e).head<3>().norm(),
                 translation_change = (next - e).tail<3>().norm();
    e = next;
    if (rotation_change < kConvergedRotation && translation_change < kConvergedTranslation) {
      converged = true;
      break;
    }
  }
  if (!converged) return out;

  // The paper's EKF keeps the gain of its only linearisation; the iterated one takes that of its optimum.
  const Eigen::Matrix<double, 6, 3> first_gain = lin.S.solve(lin.PHt.transpose()).transpose();
  const Matrix36d first_Ht = lin.Ht;
  const Eigen::Matrix3d first_W = lin.m.W;
  if (!lin.at(scene, model, prior, e, params.min_cosine)) return out;
  const bool iterated = params.iterations > 1;
  const Eigen::Matrix<double, 6, 3> K =
      iterated ? Eigen::Matrix<double, 6, 3>(lin.S.solve(lin.PHt.transpose()).transpose()) : first_gain;
  const Matrix36d& Ht = iterated ? lin.Ht : first_Ht;
  const Eigen::Matrix3d& W = iterated ? lin.m.W : first_W;

  const Eigen::LLT<Eigen::Matrix3d> noise(lin.m.W);
  if (noise.info() != Eigen::Success) return out;
  const Eigen::Vector3d Pv = lin.Ht * (lin.PHt * lin.v);
  out.cost =
      lin.v.dot(Pv) + noise.matrixL().solve(lin.m.h).squaredNorm();  // Eq. (8.2): e^T P0^-1 e + h^T W^-1 h
  out.gain = 0.5 * (logDeterminant(lin.S) - logDeterminant(noise));  // Eq. (8.3)
  if (!(out.cost <= params.gate)) return out;

  const Matrix6d IKH = Matrix6d::Identity() - K * Ht;
  Matrix6d P = IKH * prior.P * IKH.transpose() + K * W * K.transpose();  // Joseph form
  const Eigen::Matrix3d reset = leftJacobianSO3(e.head<3>());
  P.topRows<3>() = (reset * P.topRows<3>()).eval();
  P.leftCols<3>() = (P.leftCols<3>() * reset.transpose()).eval();
  out.pose.T = perturbed(prior.T, e);
  out.pose.P = 0.5 * (P + P.transpose());
  out.information = lin.m.H.transpose() * noise.solve(lin.m.H);
  out.accepted = true;
  return out;
}

}  // namespace facetloc
