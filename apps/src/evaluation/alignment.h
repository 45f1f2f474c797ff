// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/pose.h>

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
  std::size_t used = 0;              ///< pairs that it was fitted to
  double residual = 0;               ///< root mean square distance of their positions after it [m]
  double rotation_residual_deg = 0;  ///< root mean square angle between their orientations after it
};

constexpr std::size_t kLeastPairs = 3;
constexpr double kPoseLever = 0.2 / (2 * kDegree);  ///< 0.2 m count as much as 2 deg: the paper's limits

/** \brief Least squares of the distances of the positions (Umeyama 1991, without scale), as the absolute
 * trajectory error is defined. Where they lie on a line, which leaves the rotation about it free, the
 * orientations decide. Throws std::invalid_argument for less than three pairs. */
Alignment aligned(const std::vector<PosePair>& pairs);

/** \brief The motion T = (R, t) that most whole poses agree on: the minimum over T of
 *
 *     sum |T p_i - p'_i|^2 + lever^2 / 2 |R R_i - R'_i|_F^2,      |R R_i - R'_i|_F^2 / 2 = 4 sin^2(angle / 2)
 *
 * (chordal L2 mean of the orientations, in closed form together with the positions), fitted again and again
 * to those pairs that the fit before leaves within three times the median of sqrt(distance^2 + (lever
 * angle)^2).
 * \param lever displacement that counts as much as a rotation by 1 rad [m]; 0 = positions alone
 * Throws std::invalid_argument for less than three pairs. */
Alignment robustlyAligned(const std::vector<PosePair>& pairs, double lever = kPoseLever);

/** \brief A motion, and how far it leaves all of these pairs apart. */
Alignment withResiduals(const Eigen::Isometry3d& T_true_estimated, const std::vector<PosePair>& pairs);

/** \brief How far apart the positions of a pair are after the motion [m]. */
double distanceAfter(const Eigen::Isometry3d& T_true_estimated, const PosePair& pair);

/** \brief Angle between the orientations of a pair after the motion [rad]. */
double angleAfter(const Eigen::Isometry3d& T_true_estimated, const PosePair& pair);

}  // namespace facetloc
