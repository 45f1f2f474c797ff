// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "graph/pose_graph.h"

#include <facetloc/mapping/trajectory_estimation.h>

#include <set>
#include <utility>

namespace facetloc::internal {

/** \brief The graph of keyframes at these poses. All comparisons of one keyframe share its errors: together
 * they have the information of those with the keyframe before and the one after.
 *
 * \param mounting if known, all stand on one floor \param key_distance distance between keyframes, by which
 * the unevenness under them is new [m] */
PoseGraph keyframeGraph(const std::vector<Eigen::Isometry3d>& T_w_k,
                        const std::vector<KeyframeMotion>& motions,
                        const std::optional<CameraMounting>& mounting, double key_distance);
/** \brief The graph of a trajectory with the usual distance between its keyframes. */
PoseGraph keyframeGraph(const CameraTrajectory& trajectory, const std::optional<CameraMounting>& mounting);

/** \brief A place on a trajectory, as a keyframe knows it. */
struct PlaceOnTrajectory {
  int keyframe = 0;
  Eigen::Isometry3d T_k_c = Eigen::Isometry3d::Identity();  ///< pose in the frame of that keyframe
};

/** \brief Links between pairs of places, given by their indices, that are in one part: motions by the
 * trajectory's poses, covariances by its graph, computed for each pair separately. */
std::vector<Link> linksBetween(const CameraTrajectory& trajectory,
                               const std::vector<PlaceOnTrajectory>& places,
                               const std::set<std::pair<int, int>>& pairs);

/** \brief The links of a map whose local models are some images of a trajectory: from each to the next of its
 * part, and between those next to keyframes that were compared, which includes all closed loops.
 *
 * \param images numbers of the images in ascending order; link ends are indices among these. Throws
 * std::invalid_argument for a number that is no image's. */
std::vector<Link> trajectoryLinks(const CameraTrajectory& trajectory, const std::vector<std::size_t>& images);

}  // namespace facetloc::internal
