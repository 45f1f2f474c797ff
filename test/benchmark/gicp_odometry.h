// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/features/params.h>

#include <Eigen/Geometry>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

namespace facetloc::benchmarks {

/** \brief Parameters of GicpOdometry. */
struct GicpOdometryParams {
  static constexpr const char* kTitle = "Odometry by generalized ICP, as a yardstick";
  double voxel = 0.05, max_depth = 5, max_distance = 0.25;
  int iterations = 50;
  double max_rms = 0.1;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("voxel", p.voxel, 0.001, 1.0, "Edge of the voxels whose points become one [m].");
    visit("max_depth", p.max_depth, 0.1, 100.0, "Farthest depth that is used [m].");
    visit("max_distance", p.max_distance, 0.001, 10.0, "Largest distance of corresponding points [m].");
    visit("iterations", p.iterations, 1, 1000, "Iterations at most.");
    visit("max_rms", p.max_rms, 0.001, 10.0,
          "Largest root mean square distance of corresponding points that is no break [m].");
  }
};

/** \brief The way of a camera from image to image by pcl::GeneralizedIterativeClosestPoint, with the last
 * motion as the first guess. Where it does not converge, the last motion is taken, which is a break. */
class GicpOdometry {
public:
  explicit GicpOdometry(const GicpOdometryParams& params = {}) : params_(params) {}

  /** \brief The pose in the frame of the first image. */
  Eigen::Isometry3d add(const DepthImage& image);
  int breaks() const { return breaks_; }

private:
  using Cloud = pcl::PointCloud<pcl::PointXYZ>;
  Cloud::Ptr cloudOf(const DepthImage& image) const;

  GicpOdometryParams params_;
  Cloud::Ptr last_;
  Eigen::Isometry3d motion_ = Eigen::Isometry3d::Identity(), pose_ = Eigen::Isometry3d::Identity();
  int breaks_ = 0;
};

}  // namespace facetloc::benchmarks
