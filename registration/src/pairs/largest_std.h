// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace facetloc {

/** \brief Standard deviation along the direction in which it is largest. */
inline double largestStd(const Eigen::Matrix3d& covariance) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eig;
  eig.computeDirect(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, eig.eigenvalues()[2]));
}

}  // namespace facetloc
