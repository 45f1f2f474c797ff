// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include <cstddef>
#include <vector>

namespace facetloc {

/** \brief A pose of a camera as it was estimated, in one frame, and as it is, in another one. */
struct PosePair {
  double stamp = 0;  ///< [s]
  Eigen::Isometry3d estimated = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
};

/** \brief The rigid motion that brings estimated poses to true ones. */
struct Alignment {
  Eigen::Isometry3d T_true_estimated = Eigen::Isometry3d::Identity();
  std::size_t used = 0;  ///< pairs that it was fitted to
  double residual = 0;   ///< root mean square distance of their positions after it [m]
};

constexpr std::size_t kLeastPairs = 3;

/** \brief Least squares of the distances of the positions (Umeyama 1991, without scale). Where they lie on a
 * line, which leaves the rotation about it free, the orientations decide. Throws std::invalid_argument for
 * less than three pairs. */
Alignment aligned(const std::vector<PosePair>& pairs);

/** \brief The motion that most pairs agree on: fitted again and again to those that the fit before leaves
 * within three times the median distance of all. Throws std::invalid_argument for less than three pairs. */
Alignment robustlyAligned(const std::vector<PosePair>& pairs);

/** \brief How far apart the positions of a pair are after the motion [m]. */
double distanceAfter(const Eigen::Isometry3d& T_true_estimated, const PosePair& pair);

}  // namespace facetloc
