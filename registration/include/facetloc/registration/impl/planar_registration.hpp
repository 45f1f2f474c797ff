// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/registration/planar_registration.h>

namespace facetloc {

template <typename PointT>
View PlanarRegistration<PointT>::makeView(const pcl::PointCloud<PointT>& cloud, const pcl::Indices* indices,
                                          std::string& why_empty) {
  if (!isOrganized(cloud)) {
    why_empty = "the cloud is not organized";
    return {};
  }
  if (indices && !areIndicesOf(cloud, *indices)) {
    why_empty = "the indices do not fit the cloud";
    return {};
  }
  const std::optional<Intrinsics> camera = camera_ ? camera_ : recoverIntrinsics(cloud);
  if (!camera || camera->width != int(cloud.width) || camera->height != int(cloud.height)) {
    why_empty = "the camera of the cloud is not known and not to be had from its points";
    return {};
  }
  DepthImage image = depthImage(cloud, *camera);
  if (indices) {
    std::vector<float> chosen(image.depth.size(), 0.f);
    for (const int i : *indices) chosen[i] = image.depth[i];
    image.depth.swap(chosen);
  }
  View view = ViewBuilder(view_params_).build(subsampled(image, subsamplingStep(*camera, working_width_)));
  if (view.segments.empty()) why_empty = "the cloud shows no planar segment";
  return view;
}

}  // namespace facetloc
