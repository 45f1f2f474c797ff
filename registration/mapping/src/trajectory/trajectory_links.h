// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/mapping/trajectory_estimation.h>

#include <set>
#include <utility>

namespace facetloc::internal {

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
