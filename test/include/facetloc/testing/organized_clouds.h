// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/testing/synthetic_depth.h>

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <limits>

namespace facetloc::test {

/** \brief A depth image as an organized cloud; NaN where nothing was measured, as PCL's grabbers do. */
template <typename PointT>
typename pcl::PointCloud<PointT>::Ptr organizedCloud(const DepthImage& image) {
  const Intrinsics& c = image.camera;
  auto cloud = pcl::make_shared<pcl::PointCloud<PointT>>(c.width, c.height);
  cloud->is_dense = false;
  for (int v = 0; v < c.height; ++v)
    for (int u = 0; u < c.width; ++u) {
      const float z = image.at(u, v);
      PointT& p = (*cloud)(u, v);
      if (z > 0)
        p.getVector3fMap() = (double(z) * c.ray(u, v)).template cast<float>();
      else
        p.x = p.y = p.z = std::numeric_limits<float>::quiet_NaN();
    }
  return cloud;
}

}  // namespace facetloc::test
