// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/pose.h>

namespace facetloc::internal {

/** \brief How far apart two poses may be to count as one: one of the radii below. */
struct PoseRadius {
  double distance;   ///< [m]
  double angle_deg;  ///< [deg]

  bool joins(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) const {
    return isNear(a, b, distance, angle_deg);
  }
};

/** \brief A motion or a place that two sources agree on: views, an odometry. */
constexpr PoseRadius kSameMotion{0.05, 2};
/** \brief Hypotheses that are listed once. Below the tolerance that defines a correct pose, so that a wrong
 * neighbour cannot absorb the right one (localization/METHOD 11.2). */
constexpr PoseRadius kSamePlace{0.15, 2};
/** \brief Answers that do not exclude each other: one place, found more or less well
 * (localization/METHOD 11.4). */
constexpr PoseRadius kSameAnswer{0.3, 5};
/** \brief Images from there are no second look at a surface (mapping/METHOD 14.6). */
constexpr PoseRadius kSameLook{0.1, 5};
/** \brief A pose within is not another place (localization/METHOD 11.5). */
constexpr PoseRadius kSameSurroundings{1, 15};

}  // namespace facetloc::internal
