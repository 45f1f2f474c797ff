// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>

#include <Eigen/Geometry>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

namespace facetloc::benchmarks {

/** \brief The way of a camera from image to image by pcl::GeneralizedIterativeClosestPoint, with the last
 * motion as the first guess. Where it does not converge, the last motion is taken, which is a break. */
class GicpOdometry {
public:
  /** \brief The pose in the frame of the first image. */
  Eigen::Isometry3d add(const DepthImage& image);
  int breaks() const { return breaks_; }

private:
  using Cloud = pcl::PointCloud<pcl::PointXYZ>;

  Cloud::Ptr last_;
  Eigen::Isometry3d motion_ = Eigen::Isometry3d::Identity(), pose_ = Eigen::Isometry3d::Identity();
  int breaks_ = 0;
};

}  // namespace facetloc::benchmarks
