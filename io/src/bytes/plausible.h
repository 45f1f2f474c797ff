// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include <cmath>

/** \file
 * Plausible numbers of a file: those that no robot, camera or clock could have made are faults of
 * the file. Private to io. */

namespace facetloc::plausible {

constexpr double kFarthest = 1e6;     ///< [m] a map in the coordinates of a state survey fits in
constexpr double kLatest = 1e11;      ///< [s] of a clock that began in 1970: in three thousand years
constexpr double kLeastStd = 1e-9;    ///< [m], [rad] no camera measures a plane to a nanometre
constexpr double kHighest = 100;      ///< [m] of a camera above the floor on which its robot stands
constexpr double kStraightDown = 90;  ///< [deg] of its tilt, upwards and downwards
constexpr double kUpsideDown = 180;   ///< [deg] of its roll and pan, either way

inline bool isPosition(const Eigen::Vector3d& t) { return t.cwiseAbs().maxCoeff() <= kFarthest; }
inline bool isStamp(double stamp) { return std::abs(stamp) <= kLatest; }

/** \brief Positive definite, and no smaller in any direction than a sensor can make it. */
template <typename Matrix>
bool isCovariance(const Matrix& P) {
  constexpr double kSymmetry = 1e-9;  // relative to the largest value
  if (!P.allFinite() || (P - P.transpose()).cwiseAbs().maxCoeff() > kSymmetry * P.cwiseAbs().maxCoeff())
    return false;
  const Eigen::SelfAdjointEigenSolver<typename Matrix::PlainObject> eigen(P, Eigen::EigenvaluesOnly);
  return P.llt().info() == Eigen::Success && eigen.eigenvalues()[0] >= kLeastStd * kLeastStd;
}

}  // namespace facetloc::plausible
