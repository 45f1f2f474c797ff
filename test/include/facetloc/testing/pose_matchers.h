// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/so3.h>

#include <gmock/gmock.h>

#include <string>

namespace facetloc::test {

/** \brief Matches a pose within a distance [m] and an angle [deg]. */
MATCHER_P3(PoseNear, expected, metres, degrees,
           "is a pose within " + std::to_string(metres) + " m and " + std::to_string(degrees) + " deg") {
  const Eigen::Isometry3d want(expected), got(arg);
  const double distance = (got.translation() - want.translation()).norm();
  const double angle = rotationAngle(got.linear() * want.linear().transpose()) / kDegree;
  *result_listener << "differs by " << distance << " m and " << angle << " deg";
  return distance <= metres && angle <= degrees;
}

/** \brief Matches a matrix whose entries all lie within a tolerance. */
MATCHER_P2(MatrixNear, expected, tolerance,
           "is a matrix with entries within " + testing::PrintToString(tolerance)) {
  const double worst = (arg - expected).cwiseAbs().maxCoeff();
  *result_listener << "differs by up to " << worst << ":\n" << (arg - expected).eval();
  return worst <= tolerance;
}

/** \brief The smallest eigenvalue of a symmetric matrix, column-major; compiled once, for it takes Eigen ten
 * seconds. */
double smallestEigenvalue(const double* matrix, Eigen::Index size);

/** \brief Matches a symmetric matrix without an eigenvalue below -tolerance. */
MATCHER_P(IsPositiveSemidefinite, tolerance, "is symmetric without an eigenvalue below zero") {
  const double asymmetry = (arg - arg.transpose()).cwiseAbs().maxCoeff();
  const double smallest = smallestEigenvalue(arg.data(), arg.rows());
  *result_listener << "asymmetry " << asymmetry << ", smallest eigenvalue " << smallest;
  return asymmetry <= tolerance && smallest >= -tolerance;
}

/** \brief Matches a rotation matrix. */
MATCHER(IsRotation, "is a rotation matrix") {
  const double error = (arg * arg.transpose() - Eigen::Matrix3d::Identity()).norm();
  *result_listener << "R R^T - I has norm " << error << ", det R = " << arg.determinant();
  return error < 1e-12 && arg.determinant() > 0;
}

}  // namespace facetloc::test
