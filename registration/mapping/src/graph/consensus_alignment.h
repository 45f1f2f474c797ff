// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/pose.h>

#include <functional>
#include <optional>
#include <vector>

namespace facetloc::internal {

/** \brief A keyframe of a session that was found in a map. */
struct FoundKeyframe {
  int keyframe = 0;
  PoseWithCovariance T_w_c;  ///< pose in the map
};

/** \brief Tolerance for the distance of two found keyframes, beyond the errors of the session. */
struct PlaceTolerance {
  double distance = 0;  ///< [m]
  double rotation = 0;  ///< [rad]
};

/** \brief T_a_b of two keyframes by the session alone; nothing if it does not know. */
using RelativePose = std::function<std::optional<PoseWithCovariance>(int a, int b)>;

/** \brief The largest set of found keyframes in which each two are as far from each other as the session
 * says.
 *
 * Nothing if it is smaller than `least`, or if a set that contradicts it is more than half as large: places
 * that look the same confirm each other. Same input, same answer. */
std::vector<FoundKeyframe> consensusAlignment(const std::vector<FoundKeyframe>& found,
                                              const RelativePose& relative, const PlaceTolerance& tolerance,
                                              std::size_t least);

}  // namespace facetloc::internal
