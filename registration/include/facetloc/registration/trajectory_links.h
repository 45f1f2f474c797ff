// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/registration/trajectory_estimation.h>

namespace facetloc {

/** \brief The links of a map whose local models are some images of a trajectory: from each to the next of its
 * part, and between those next to keyframes that were compared, which includes all closed loops. Motions are
 * those of the trajectory, covariances what its graph knows of each by itself.
 *
 * \param images numbers of the images in ascending order; link ends are indices among these. Throws
 * std::invalid_argument for a number that is no image's. */
std::vector<Link> trajectoryLinks(const CameraTrajectory& trajectory, const std::vector<std::size_t>& images);

}  // namespace facetloc
