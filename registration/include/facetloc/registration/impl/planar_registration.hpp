// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/registration/planar_registration.h>

namespace facetloc {

template <typename PointT>
View PlanarRegistration<PointT>::makeView(const pcl::PointCloud<PointT>& cloud, const pcl::Indices* indices) {
  const std::optional<Intrinsics> camera = camera_ ? camera_ : recoverIntrinsics(cloud);
  const bool organized = cloud.height > 1 && cloud.size() == std::size_t(cloud.width) * cloud.height;
  if (!organized || !camera || camera->width != int(cloud.width) || camera->height != int(cloud.height))
    return {};
  DepthImage image = depthImage(cloud, *camera);
  if (indices) {
    std::vector<float> chosen(image.depth.size(), 0.f);
    for (const int i : *indices)
      if (i >= 0 && i < static_cast<int>(chosen.size())) chosen[i] = image.depth[i];
    image.depth.swap(chosen);
  }
  return ViewBuilder(view_params_).build(subsampled(image, subsamplingStep(*camera, working_width_)));
}

}  // namespace facetloc
