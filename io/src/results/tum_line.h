// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/text.h"
#include "results/pose_columns.h"

#include <facetloc/io/trajectory.h>

#include <cmath>
#include <stdexcept>
#include <string>

/** \file
 * Trajectories in the TUM format line by line, private to io. */

namespace facetloc::tum {

constexpr const char* kHeader = "# timestamp tx ty tz qx qy qz qw\n";
constexpr int kStampDecimals = 6;

/** \brief Throws std::invalid_argument for a pose that is not finite. */
inline std::string line(const StampedPose& pose) {
  if (!std::isfinite(pose.stamp) || !pose.T_w_c.matrix().allFinite())
    throw std::invalid_argument("a pose of the trajectory is not finite");
  std::string out = text::decimals(pose.stamp, kStampDecimals);
  for (const double value : toColumns(pose.T_w_c)) out.append(" ").append(text::significant(value));
  return out + "\n";
}

}  // namespace facetloc::tum
