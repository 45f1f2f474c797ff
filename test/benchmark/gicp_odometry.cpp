// SPDX-License-Identifier: BSD-3-Clause
#include "gicp_odometry.h"

#include "rigid.h"

#include <pcl/filters/voxel_grid.h>
#include <pcl/registration/gicp.h>

namespace facetloc::benchmarks {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

constexpr std::size_t kLeastPoints = 100;
constexpr float kVoxel = 0.05f;        // edge of the voxels whose points become one [m]
constexpr double kMaxDepth = 5;        // farthest depth that is used [m]
constexpr double kMaxDistance = 0.25;  // largest distance of corresponding points [m]
constexpr int kIterations = 50;
constexpr double kMaxRms = 0.1;  // root mean square distance of corresponding points that is no break [m]

Cloud::Ptr cloudOf(const DepthImage& image) {
  const Cloud::Ptr all(new Cloud), thinned(new Cloud);
  for (int v = 0; v < image.camera.height; ++v)
    for (int u = 0; u < image.camera.width; ++u) {
      const double z = image.at(u, v);
      if (!isMeasured(static_cast<float>(z)) || z > kMaxDepth) continue;
      const Eigen::Vector3f p = (z * image.camera.ray(u, v)).cast<float>();
      all->emplace_back(p.x(), p.y(), p.z());
    }
  pcl::VoxelGrid<pcl::PointXYZ> grid;
  grid.setInputCloud(all);
  grid.setLeafSize(kVoxel, kVoxel, kVoxel);
  grid.filter(*thinned);
  return thinned;
}

}  // namespace

Eigen::Isometry3d GicpOdometry::add(const DepthImage& image) {
  const Cloud::Ptr target = last_;
  last_ = cloudOf(image);
  if (!target) return pose_;
  bool found = false;
  if (target->size() >= kLeastPoints && last_->size() >= kLeastPoints) {
    pcl::GeneralizedIterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> gicp;
    gicp.setInputSource(last_);
    gicp.setInputTarget(target);
    gicp.setMaxCorrespondenceDistance(kMaxDistance);
    gicp.setMaximumIterations(kIterations);
    Cloud moved;
    gicp.align(moved, motion_.matrix().cast<float>());
    found = gicp.hasConverged() && gicp.getFitnessScore(kMaxDistance * kMaxDistance) <= kMaxRms * kMaxRms;
    if (found) motion_ = rigid(gicp.getFinalTransformation());
  }
  breaks_ += !found;
  return pose_ = pose_ * motion_;
}

}  // namespace facetloc::benchmarks
