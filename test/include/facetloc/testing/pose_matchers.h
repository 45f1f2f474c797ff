// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/pose.h>

#include <gmock/gmock.h>

#include <string>

namespace facetloc::test {

/** \name Implementations of the matchers, compiled once for all types of matrices. */
/// @{
using AnyMatrix = Eigen::Ref<const Eigen::MatrixXd>;
using Listener = testing::MatchResultListener;
bool posesNear(const Eigen::Isometry3d& got, const Eigen::Isometry3d& expected, double metres, double degrees,
               Listener& listener);
bool matricesNear(const AnyMatrix& got, const AnyMatrix& expected, double tolerance, Listener& listener);
bool positiveSemidefinite(const AnyMatrix& matrix, double tolerance, Listener& listener);
bool rotation(const Eigen::Matrix3d& matrix, Listener& listener);
/// @}

/** \brief Matches a pose within a distance [m] and an angle [deg]. */
MATCHER_P3(PoseNear, expected, metres, degrees,
           "is a pose within " + std::to_string(metres) + " m and " + std::to_string(degrees) + " deg") {
  return posesNear(Eigen::Isometry3d(arg), Eigen::Isometry3d(expected), metres, degrees, *result_listener);
}

/** \brief Matches a matrix whose entries all lie within a tolerance. */
MATCHER_P2(MatrixNear, expected, tolerance,
           "is a matrix with entries within " + testing::PrintToString(tolerance)) {
  return matricesNear(arg, expected, tolerance, *result_listener);
}

/** \brief Matches a symmetric matrix without an eigenvalue below -tolerance. */
MATCHER_P(IsPositiveSemidefinite, tolerance, "is symmetric without an eigenvalue below zero") {
  return positiveSemidefinite(arg, tolerance, *result_listener);
}

/** \brief Matches a rotation matrix. */
MATCHER(IsRotation, "is a rotation matrix") { return rotation(arg, *result_listener); }

}  // namespace facetloc::test
