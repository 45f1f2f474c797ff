// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

namespace facetloc {

constexpr double kDegree = 3.14159265358979323846 / 180.0;  ///< [rad]

/** \brief Cross-product matrix: skew(a) b = a x b. */
Eigen::Matrix3d skew(const Eigen::Vector3d& a);

/** \brief Rotation matrix of a rotation vector [rad]; exact to rounding, also at zero. */
Eigen::Matrix3d expSO3(const Eigen::Vector3d& phi);

/** \brief Rotation vector of a rotation matrix [rad], norm in [0, pi]; at pi the sign of the axis is
 * arbitrary. */
Eigen::Vector3d logSO3(const Eigen::Matrix3d& R);

/** \brief Left Jacobian: Exp(phi + d) = Exp(J d) Exp(phi) to first order in d (METHOD 1.2). */
Eigen::Matrix3d leftJacobianSO3(const Eigen::Vector3d& phi);

/** \brief Angle of a rotation [rad] in [0, pi]; accurate near zero, where the trace alone is not. */
double rotationAngle(const Eigen::Matrix3d& R);

/** \brief The smallest rotation that turns one direction into another; any of them if they are opposite. */
Eigen::Matrix3d rotationBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

}  // namespace facetloc
