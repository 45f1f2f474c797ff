// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "depth/depth_consistency.h"

#include <vector>

namespace facetloc::internal {

/** \brief Search for the last translation by dense depth (METHOD 9). */
struct DepthAlignmentParams {
  double range = 1.4;      ///< on both sides of the prior mean [m]
  double step = 0.1;       ///< spacing of the coarse search [m]: near a wall, pixels a step off do not agree
  double prominence = 12;  ///< margin of the best position over the mean [net agreements of the coarse grid]
  double runner_up = 8;    ///< how far below the best a second maximum may lie
  double std = 0.03;       ///< uncertainty of the found position [m]
};

/** \brief Positions along a unit direction at which both depth pictures agree best, best first, at most two;
 * empty if nothing along the direction distinguishes the positions.
 *
 * \param T_m_c pose whose translation along direction is not known; \param centre prior mean of direction . t
 * [m]. \return values of direction . t [m]. */
std::vector<double> alignDepth(const DepthPicture& scene, const DepthPicture& model,
                               const Eigen::Isometry3d& T_m_c, const Eigen::Vector3d& direction,
                               double centre, const DepthComparison& comparison,
                               const DepthAlignmentParams& params = {});

}  // namespace facetloc::internal
