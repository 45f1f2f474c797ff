// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

namespace facetloc {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

constexpr double kDegree = 3.14159265358979323846 / 180.0;  ///< [rad]

/** \brief Cross-product matrix: skew(a) b = a x b. */
Eigen::Matrix3d skew(const Eigen::Vector3d& a);

/** \brief Rotation matrix of a rotation vector [rad]; exact to rounding, also at zero. */
Eigen::Matrix3d expSO3(const Eigen::Vector3d& phi);

/** \brief Rotation vector of a rotation matrix [rad], norm in [0, pi]; at pi the sign of the axis is
 * arbitrary. */
Eigen::Vector3d logSO3(const Eigen::Matrix3d& R);

/** \brief Left Jacobian: Exp(phi + d) = Exp(J d) Exp(phi) to first order in d (METHOD 0). */
Eigen::Matrix3d leftJacobianSO3(const Eigen::Vector3d& phi);

/** \brief Angle of a rotation [rad] in [0, pi]; accurate near zero, where the trace alone is not. */
double rotationAngle(const Eigen::Matrix3d& R);

/** \brief The smallest rotation that turns one direction into another; any of them if they are opposite. */
Eigen::Matrix3d rotationBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

/** \brief A pose T_a_b and the covariance of its left, decoupled perturbation (d phi, d t) in frame a:
 * R <- Exp(d phi) R, t <- t + d t (METHOD 0). Radians and metres. */
struct PoseWithCovariance {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  Matrix6d P = Matrix6d::Zero();
};

/** \brief The covariance P of a left, decoupled perturbation, told in axes that R turns its own into. */
Matrix6d turned(const Eigen::Matrix3d& R, const Matrix6d& P);

/** \brief The pose of c in b, told in a. */
PoseWithCovariance operator*(const Eigen::Isometry3d& T_a_b, const PoseWithCovariance& T_b_c);

/** \brief True if two poses are no farther apart than that [m, deg]. */
bool isNear(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double translation, double rotation_deg);

/** \brief T moved by a left, decoupled perturbation (d phi, d t). Its rotation stays orthonormal, however
 * often this is done. */
Eigen::Isometry3d perturbed(const Eigen::Isometry3d& T, const Vector6d& d);

/** \brief The left, decoupled perturbation that leads from T0 to T: perturbed(T0, d) = T. */
Vector6d perturbation(const Eigen::Isometry3d& T0, const Eigen::Isometry3d& T);

}  // namespace facetloc
