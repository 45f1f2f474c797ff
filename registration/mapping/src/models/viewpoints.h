// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "models/free_places.h"

#include <facetloc/features/camera_model.h>
#include <facetloc/mapping/model_map.h>

#include <cstdint>

namespace facetloc::internal {

/** \brief A camera that viewpoints are looked for. */
struct ViewpointSearch {
  std::shared_ptr<const Surface> surface;
  Camera camera;                  ///< with the intrinsics of the images that are rendered
  PlaceRules places;              ///< its frame has z up
  std::vector<double> tilts_deg;  ///< tilts of the optical axis below the horizon
  Eigen::Isometry3d T_w_up = Eigen::Isometry3d::Identity();  ///< to the surface's frame from one with z up
  ForEach forEach;                                           ///< runs the work, with progress
};

/** \brief Viewpoints for that camera (METHOD 3). Fills in findings. */
std::vector<Eigen::Isometry3d> findViewpoints(const ViewpointSearch& search, const ModelMapParams& params,
                                              ModelFindings& findings);

/** \brief The view of a camera at a pose, in a few pixels. */
struct SmallView {
  Eigen::Isometry3d T_w_c;
  std::vector<float> depth;  ///< [m]; 0 = unknown
};

/** \brief Share of the known pixels of a view that another one of the same intrinsics also shows. */
double sharedPart(const SmallView& of, const SmallView& in, const Intrinsics& camera);

/** \brief Which views another one may stand for. */
struct Substitutes {
  struct Entry {
    std::uint32_t view;
    float shared;  ///< part of that view that the other one shows
  };
  std::vector<std::vector<Entry>> of;  ///< grouped by the representative view
};

/** \brief Few views, such that for each view there is one that shows at least that part of it: the greedy set
 * cover, in ascending order. */
std::vector<std::size_t> coveringViews(const Substitutes& substitutes, double shared);

}  // namespace facetloc::internal
