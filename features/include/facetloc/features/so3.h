// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace facetloc {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

constexpr double kDegree = 3.14159265358979323846 / 180.0;  ///< [rad]

/** \brief Cross-product matrix: skew(a) b = a x b. */
inline Eigen::Matrix3d skew(const Eigen::Vector3d& a) {
  Eigen::Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

/** \brief Rotation matrix of a rotation vector [rad]; exact to rounding, also at zero. */
inline Eigen::Matrix3d expSO3(const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  if (angle < 1e-9) return Eigen::Matrix3d::Identity() + skew(phi);
  return Eigen::AngleAxisd(angle, phi / angle).toRotationMatrix();
}

/** \brief Rotation vector of a rotation matrix [rad], norm in [0, pi]; at pi the sign of the axis is
 * arbitrary. */
inline Eigen::Vector3d logSO3(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd a(R);
  return a.angle() * a.axis();
}

/** \brief Left Jacobian: Exp(phi + d) = Exp(J d) Exp(phi) to first order in d (METHOD 0). */
inline Eigen::Matrix3d leftJacobianSO3(const Eigen::Vector3d& phi) {
  const double f = phi.norm();
  const Eigen::Matrix3d K = skew(phi);
  if (f < 1e-5) return Eigen::Matrix3d::Identity() + 0.5 * K + K * K / 6.0;
  return Eigen::Matrix3d::Identity() + (1 - std::cos(f)) / (f * f) * K +
         (f - std::sin(f)) / (f * f * f) * K * K;
}

/** \brief Angle of a rotation [rad] in [0, pi]; accurate near zero, where the trace alone is not. */
inline double rotationAngle(const Eigen::Matrix3d& R) {
  const Eigen::Vector3d twice_sine_axis(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  return std::atan2(0.5 * twice_sine_axis.norm(), 0.5 * (R.trace() - 1.0));
}

/** \brief A pose T_a_b and the covariance of its left, decoupled perturbation (d phi, d t) in frame a:
 * R <- Exp(d phi) R, t <- t + d t (METHOD 0). Radians and metres. */
struct PoseWithCovariance {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  Matrix6d P = Matrix6d::Zero();
};

/** \brief The covariance P of a left, decoupled perturbation, told in axes that R turns its own into. */
inline Matrix6d turned(const Eigen::Matrix3d& R, const Matrix6d& P) {
  Matrix6d out;
  for (const int row : {0, 3})
    for (const int column : {0, 3})
      out.block<3, 3>(row, column) = R * P.block<3, 3>(row, column) * R.transpose();
  return out;
}

/** \brief The pose of c in b, told in a. */
inline PoseWithCovariance operator*(const Eigen::Isometry3d& T_a_b, const PoseWithCovariance& T_b_c) {
  return {T_a_b * T_b_c.T, turned(T_a_b.linear(), T_b_c.P)};
}

/** \brief T moved by a left, decoupled perturbation (d phi, d t). */
inline Eigen::Isometry3d perturbed(const Eigen::Isometry3d& T, const Vector6d& d) {
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  out.linear() = expSO3(d.head<3>()) * T.linear();
  out.translation() = T.translation() + d.tail<3>();
  return out;
}

/** \brief The left, decoupled perturbation that leads from T0 to T: perturbed(T0, d) = T. */
inline Vector6d perturbation(const Eigen::Isometry3d& T0, const Eigen::Isometry3d& T) {
  Vector6d d;
  d << logSO3(T.linear() * T0.linear().transpose()), T.translation() - T0.translation();
  return d;
}

}  // namespace facetloc
