// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "models/seen_space.h"

#include <facetloc/mapping/densified_map.h>

#include <Eigen/Geometry>

#include <vector>

namespace facetloc::internal {

/** \brief Pose of an image of a drive. */
struct DrivenPose {
  Eigen::Isometry3d T_w_c;
  Eigen::Vector3d upwards;  ///< unit vector in the optical frame
};

/** \brief Where a view may be rendered. */
struct PlaceBeside {
  Eigen::Isometry3d T_w_c;
  std::size_t beside = 0;  ///< index of the driven pose that it belongs to
  double known_share = 0;  ///< share of its pixels
};

/** \brief Poses within reach of a drive that no image of it is near, as high and as inclined as the driven
 * one that they are beside, in all headings; only where the way from there is free. */
std::vector<PlaceBeside> placesBeside(const std::vector<DrivenPose>& drive, const SeenSpace& space,
                                      const DensifyParams& params);

/** \brief The places with enough known pixels, the best known first, without those near a better one.
 */
std::vector<PlaceBeside> spreadOut(std::vector<PlaceBeside> places, const DensifyParams& params,
                                   std::size_t most);

}  // namespace facetloc::internal
