// SPDX-License-Identifier: BSD-3-Clause
#include "base/median.h"
#include "models/model_points.h"
#include "models/ray_caster.h"
#include "threads/in_parallel.h"

#include <facetloc/mapping/mesh_surface.h>

#include <Eigen/Eigenvalues>
#include <pcl/PCLPointCloud2.h>
#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <cmath>
#include <fmt/core.h>
#include <stdexcept>
#include <vector>

namespace facetloc {

using namespace internal;

namespace {

constexpr int kNeighbours = 12;  // with the point itself
constexpr double kIsolated = 3;  // times as far from its neighbours as these are from theirs
constexpr double kNearest = 10;  // times the spacing: neighbours are 0.1 rad apart
// Radius of a disc, times the spacing: of a surface that is sampled at random exp(-pi kRadius^2) is not
// covered.
constexpr float kRadius = 1.5f;
constexpr std::size_t kBlock = 4096;  // points that a thread takes at a time

/** A point as a piece of surface. */
struct Surfel {
  Eigen::Vector3f centre, normal;
  float spacing = 0;   // spacing of the points around it [m]
  float residual = 0;  // distance of these points from their plane [m]
};

using Points = pcl::PointCloud<pcl::PointXYZ>;

/** On the plane of the neighbours, which averages the scan's noise. */
Surfel surfelOf(const Points& points, std::size_t i, const pcl::Indices& neighbours,
                const std::vector<float>& squares) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto j : neighbours) mean += points[static_cast<std::size_t>(j)].getVector3fMap().cast<double>();
  const double n = static_cast<double>(neighbours.size());
  mean /= n;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const auto j : neighbours) {
    const Eigen::Vector3d d = points[static_cast<std::size_t>(j)].getVector3fMap().cast<double>() - mean;
    scatter += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(scatter);
  const Eigen::Vector3d normal = axes.eigenvectors().col(0), p = points[i].getVector3fMap().cast<double>();
  Surfel surfel;
  surfel.centre = (p - normal * normal.dot(p - mean)).cast<float>();
  surfel.normal = normal.cast<float>();
  // So many points lie in a disc of the radius of the farthest one.
  surfel.spacing = static_cast<float>(std::sqrt(M_PI * squares.back() / n));
  surfel.residual = static_cast<float>(std::sqrt(std::max(0.0, axes.eigenvalues()[0]) / (n - 3)));
  return surfel;
}

/** Surfels of the points that belong to a surface, in their order. */
std::vector<Surfel> surfelsOf(const Points::ConstPtr& points, int threads) {
  pcl::KdTreeFLANN<pcl::PointXYZ> tree(false);
  tree.setInputCloud(points);
  const std::size_t n = points->size();
  std::vector<Surfel> all(n);
  const auto forEachPoint = [&](const auto& function) {
    forEachInParallel(static_cast<int>((n + kBlock - 1) / kBlock), threads, [&](int block) {
      pcl::Indices indices;
      std::vector<float> squares;
      const std::size_t first = static_cast<std::size_t>(block) * kBlock;
      for (std::size_t i = first; i < std::min(n, first + kBlock); ++i) {
        tree.nearestKSearch((*points)[i], kNeighbours, indices, squares);
        function(i, indices, squares);
      }
    });
  };
  forEachPoint([&](std::size_t i, const pcl::Indices& indices, const std::vector<float>& squares) {
    all[i] = surfelOf(*points, i, indices, squares);
  });
  std::vector<char> isolated(n);
  forEachPoint([&](std::size_t i, const pcl::Indices& indices, const std::vector<float>&) {
    std::vector<float> around;
    for (const auto j : indices) around.push_back(all[static_cast<std::size_t>(j)].spacing);
    isolated[i] = all[i].spacing > kIsolated * median(around);
  });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < n; ++i)
    if (!isolated[i]) all[kept++] = all[i];
  all.resize(kept);
  return all;
}

}  // namespace

CloudSurface::CloudSurface(const pcl::PCLPointCloud2& cloud, int threads) {
  const auto points = std::make_shared<Points>();
  {
    const ModelPoints positions(cloud);
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const Eigen::Vector3f p = positions[i];
      if (!p.allFinite()) continue;
      points->emplace_back(p.x(), p.y(), p.z());
      bounds_.extend(p.cast<double>());
    }
    left_out_ = positions.size() - points->size();
  }
  if (points->size() < kNeighbours)
    throw std::invalid_argument(fmt::format("it has {} points, too few for a surface", points->size()));
  requireResolved(bounds_);
  const std::vector<Surfel> surfels = surfelsOf(points, threads);
  left_out_ += points->size() - surfels.size();
  points_ = surfels.size();
  if (points_ < kNeighbours) throw std::invalid_argument("its points do not lie on surfaces");
  std::vector<float> values;
  for (const Surfel& s : surfels) values.push_back(s.spacing);
  spacing_ = median(values);
  values.clear();
  for (const Surfel& s : surfels) values.push_back(s.residual);
  residual_ = median(values);
  rays_ = std::make_unique<RayCaster>();
  rays_->setDiscs(points_, [&](const RayCaster::Discs& all) {
    for (std::size_t i = 0; i < points_; ++i) {
      Eigen::Map<Eigen::Vector4f>(all.centres + 4 * i) << surfels[i].centre, kRadius * surfels[i].spacing;
      Eigen::Map<Eigen::Vector3f>(all.normals + 3 * i) = surfels[i].normal;
    }
  });
}

CloudSurface::~CloudSurface() = default;

DepthImage CloudSurface::render(const Intrinsics& camera, const Eigen::Isometry3d& T_w_c) const {
  DepthImage image = rays_->depth(camera, T_w_c);
  const auto nearest = static_cast<float>(kNearest * spacing_);
  for (float& z : image.depth)
    if (z < nearest) z = 0;
  return image;
}

}  // namespace facetloc
