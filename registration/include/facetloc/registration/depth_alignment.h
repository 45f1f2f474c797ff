// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/registration/depth_consistency.h>

#include <vector>

namespace facetloc {

/** \brief Search for the last translation by dense depth (METHOD_MEASURED 10.5). */
struct DepthAlignmentParams {
  double range = 1.4;  ///< on both sides of the prior mean [m]
  double step = 0.1;   ///< of the coarse search [m]: near a wall, pixels a step off do not agree
  double prominence =
      12;  ///< by which the best position must exceed the mean [net agreements of the coarse grid]
  double runner_up = 8;  ///< how far below the best a second maximum may lie
  double std = 0.03;     ///< uncertainty of the found position [m]

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& field) {
    field("align_range", p.range, 0.01, 100.0,
          "Search range for the last translation on both sides of the prior mean [m].");
    field("align_step", p.step, 0.001, 10.0, "Coarse step of that search [m].");
    field("align_prominence", p.prominence, 0.0, 1e6,
          "By how many net agreeing pixels the best position must exceed the mean.");
    field("align_runner_up", p.runner_up, 0.0, 1e6,
          "How many net agreeing pixels a second maximum may lie below the best.");
    field("align_std", p.std, 0.0001, 10.0, "Uncertainty of the position found, standard deviation [m].");
  }
  void validate() const { checkRanges(*this); }
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

}  // namespace facetloc
