// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "graph/pose_graph.h"

#include <facetloc/mapping/trajectory_estimation.h>

namespace facetloc::internal {

/** \brief The graph of keyframes at these poses. All comparisons of one keyframe share its errors: together
 * they have the information of those with the keyframe before and the one after.
 *
 * \param mounting if known, all stand on one floor \param key_distance way between keyframes, by which the
 * unevenness under them is new [m] */
PoseGraph keyframeGraph(const std::vector<Eigen::Isometry3d>& T_w_k,
                        const std::vector<KeyframeMotion>& motions,
                        const std::optional<CameraMounting>& mounting, double key_distance);
/** \brief The graph of a trajectory with the usual way between its keyframes. */
PoseGraph keyframeGraph(const CameraTrajectory& trajectory, const std::optional<CameraMounting>& mounting);

}  // namespace facetloc::internal
