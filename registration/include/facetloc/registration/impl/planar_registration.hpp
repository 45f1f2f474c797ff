// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/registration/planar_registration.h>
#include <facetloc/segmentation/impl/view_builder.hpp>

namespace facetloc {

template <typename PointT>
View PlanarRegistration<PointT>::makeView(const pcl::PointCloud<PointT>& cloud, const pcl::Indices* indices,
                                          std::string& why_empty) {
  const auto view = ViewBuilder(camera_, view_params_, working_width_).build(&cloud, indices, why_empty);
  if (!view) return {};
  if (view->segments.empty()) why_empty = "the cloud shows no planar segment";
  return *view;
}

template <typename PointT>
std::optional<View> PlanarRegistration<PointT>::makeFinerView(const pcl::PointCloud<PointT>& cloud,
                                                              const pcl::Indices* indices) {
  std::string why_empty;
  const auto image = depthImageOfInput(&cloud, indices, camera_.intrinsics, why_empty);
  if (!image || subsamplingStep(image->camera, working_width_) == 1) return std::nullopt;
  return ViewBuilder(camera_, view_params_).build(*image);
}

}  // namespace facetloc
