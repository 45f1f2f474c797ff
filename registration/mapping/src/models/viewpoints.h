// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "sessions/parallel_stage.h"

#include <facetloc/mapping/model_map.h>

#include <vector>

namespace facetloc::internal {

/** \brief A camera that viewpoints are looked for. */
struct ViewpointSearch {
  std::shared_ptr<const Surface> surface;
  Camera camera;                        ///< with the intrinsics of the images that are rendered
  std::vector<double> heights;          ///< above the floor [m]
  std::vector<double> tilts_deg;        ///< tilts of the optical axis below the horizon
  bool stands = false;                  ///< on the floor, as on a robot
  std::vector<Eigen::Vector3d> inside;  ///< places of the areas to fill, in the surface's frame
  Eigen::Isometry3d T_w_up = Eigen::Isometry3d::Identity();  ///< to the surface's frame from one with z up
  std::size_t most_places = ModelMap::kMostPlaces;
  int threads = 1;
  MapProgressCallback progress;
};

/** \brief Viewpoints for that camera (METHOD 3). Fills in findings. */
std::vector<Eigen::Isometry3d> findViewpoints(const ViewpointSearch& search, const ModelMapParams& params,
                                              ModelFindings& findings);

}  // namespace facetloc::internal
