// SPDX-License-Identifier: BSD-3-Clause
#include "gicp_odometry.h"

#include "rigid.h"

#include <pcl/filters/voxel_grid.h>
#include <pcl/registration/gicp.h>

namespace facetloc::benchmarks {
namespace {

constexpr std::size_t kLeastPoints = 100;

}  // namespace

GicpOdometry::Cloud::Ptr GicpOdometry::cloudOf(const DepthImage& image) const {
  const Cloud::Ptr all(new Cloud), thinned(new Cloud);
  for (int v = 0; v < image.camera.height; ++v)
    for (int u = 0; u < image.camera.width; ++u) {
      const double z = image.at(u, v);
      if (!isMeasured(static_cast<float>(z)) || z > params_.max_depth) continue;
      const Eigen::Vector3f p = (z * image.camera.ray(u, v)).cast<float>();
      all->emplace_back(p.x(), p.y(), p.z());
    }
  pcl::VoxelGrid<pcl::PointXYZ> grid;
  grid.setInputCloud(all);
  const auto edge = static_cast<float>(params_.voxel);
  grid.setLeafSize(edge, edge, edge);
  grid.filter(*thinned);
  return thinned;
}

Eigen::Isometry3d GicpOdometry::add(const DepthImage& image) {
  const Cloud::Ptr target = last_;
  last_ = cloudOf(image);
  if (!target) return pose_;
  bool found = false;
  if (target->size() >= kLeastPoints && last_->size() >= kLeastPoints) {
    pcl::GeneralizedIterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> gicp;
    gicp.setInputSource(last_);
    gicp.setInputTarget(target);
    gicp.setMaxCorrespondenceDistance(params_.max_distance);
    gicp.setMaximumIterations(params_.iterations);
    Cloud moved;
    gicp.align(moved, motion_.matrix().cast<float>());
    const double square = params_.max_distance * params_.max_distance;
    found = gicp.hasConverged() && gicp.getFitnessScore(square) <= params_.max_rms * params_.max_rms;
    if (found) motion_ = rigid(gicp.getFinalTransformation());
  }
  breaks_ += !found;
  return pose_ = pose_ * motion_;
}

}  // namespace facetloc::benchmarks
