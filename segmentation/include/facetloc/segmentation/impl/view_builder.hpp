// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/organized_cloud.h>
#include <facetloc/segmentation/view_builder.h>

namespace facetloc {

template <typename PointT>
std::optional<View> ViewBuilder::build(const pcl::PointCloud<PointT>* cloud, const pcl::Indices* indices,
                                       std::string& why_not, const std::optional<Gravity>& gravity) {
  const auto image = depthImageOfInput(cloud, indices, camera_->intrinsics, why_not);
  if (!image) return std::nullopt;
  return build(*image, gravity);
}

}  // namespace facetloc
