// SPDX-License-Identifier: BSD-3-Clause
#include "pcl_planes.h"

#include <facetloc/features/pose.h>

#include <pcl/features/integral_image_normal.h>
#include <pcl/segmentation/organized_multi_plane_segmentation.h>

#include <vector>

namespace facetloc::benchmarks {

LabelImage planesByPcl(const pcl::PointCloud<pcl::PointXYZ>::ConstPtr& cloud, unsigned min_inliers) {
  const pcl::PointCloud<pcl::Normal>::Ptr normals(new pcl::PointCloud<pcl::Normal>);
  pcl::IntegralImageNormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
  estimation.setNormalEstimationMethod(estimation.COVARIANCE_MATRIX);
  estimation.setMaxDepthChangeFactor(0.02f);
  estimation.setNormalSmoothingSize(10.0f);
  estimation.setInputCloud(cloud);
  estimation.compute(*normals);

  pcl::OrganizedMultiPlaneSegmentation<pcl::PointXYZ, pcl::Normal, pcl::Label> segmentation;
  segmentation.setMinInliers(min_inliers);
  segmentation.setAngularThreshold(3 * kDegree);
  segmentation.setDistanceThreshold(0.02);
  segmentation.setInputNormals(normals);
  segmentation.setInputCloud(cloud);
  std::vector<pcl::PlanarRegion<pcl::PointXYZ>, Eigen::aligned_allocator<pcl::PlanarRegion<pcl::PointXYZ>>>
      regions;
  std::vector<pcl::ModelCoefficients> planes;
  std::vector<pcl::PointIndices> inliers, of_labels, boundaries;
  pcl::PointCloud<pcl::Label>::Ptr labels(new pcl::PointCloud<pcl::Label>);
  segmentation.segmentAndRefine(regions, planes, inliers, labels, of_labels, boundaries);

  LabelImage found;
  found.width = static_cast<int>(cloud->width), found.height = static_cast<int>(cloud->height);
  found.label.assign(cloud->size(), 0);
  for (std::size_t k = 0; k < inliers.size(); ++k)
    for (const auto i : inliers[k].indices) found.label[i] = static_cast<std::uint16_t>(k + 1);
  return found;
}

}  // namespace facetloc::benchmarks
