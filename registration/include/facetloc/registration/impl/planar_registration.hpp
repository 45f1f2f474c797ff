// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/registration/planar_registration.h>

namespace facetloc {

template <typename PointT>
View PlanarRegistration<PointT>::makeView(const pcl::PointCloud<PointT>& cloud, const pcl::Indices* indices,
                                          std::string& why_empty) {
  const std::optional<Intrinsics> camera = cameraOfInput(&cloud, indices, camera_.intrinsics, why_empty);
  if (!camera) return {};
  DepthImage image = depthImage(cloud, *camera);
  if (indices) {
    std::vector<float> chosen(image.depth.size(), 0.f);
    for (const int i : *indices) chosen[i] = image.depth[i];
    image.depth.swap(chosen);
  }
  View view =
      ViewBuilder(camera_, view_params_).build(subsampled(image, subsamplingStep(*camera, working_width_)));
  if (view.segments.empty()) why_empty = "the cloud shows no planar segment";
  return view;
}

}  // namespace facetloc
