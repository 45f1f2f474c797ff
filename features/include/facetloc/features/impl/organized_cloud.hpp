// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/features/organized_cloud.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace facetloc {
namespace detail {

/** \brief Least squares of x = (i - centre) / focal from the sums of (i, x). */
struct PixelLine {
  double n = 0, i = 0, x = 0, ii = 0, ix = 0;

  void add(double pixel, double slope) {
    n += 1, i += pixel, x += slope, ii += pixel * pixel, ix += pixel * slope;
  }
  bool solve(double& focal, double& centre) const {
    const double var = ii - i * i / n, cov = ix - i * x / n;
    if (!(var > 0) || !(cov > 1e-9 * var)) return false;
    focal = var / cov;
    centre = i / n - focal * x / n;
    return true;
  }
};

template <typename PointT>
bool inFront(const PointT& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && isMeasured(p.z);
}

}  // namespace detail

template <typename PointT>
std::optional<Intrinsics> recoverIntrinsics(const pcl::PointCloud<PointT>& cloud) {
  if (!isOrganized(cloud)) return {};
  detail::PixelLine columns, rows;
  for (std::uint32_t v = 0, k = 0; v < cloud.height; ++v)
    for (std::uint32_t u = 0; u < cloud.width; ++u, ++k) {
      const PointT& p = cloud[k];
      if (!detail::inFront(p)) continue;
      columns.add(u, double(p.x) / p.z);
      rows.add(v, double(p.y) / p.z);
    }
  constexpr double kEnough = 16;
  Intrinsics c{int(cloud.width), int(cloud.height), 0, 0, 0, 0};
  if (columns.n < kEnough || !columns.solve(c.fx, c.cx) || !rows.solve(c.fy, c.cy) || !c.valid()) return {};

  // A cloud that is organized but no pinhole image shows by where its points are seen.
  if (!isImageOf(cloud, c, 1.0)) return {};
  return c;
}

// Samples lie on diagonals, which meet all columns and rows.
template <typename PointT>
bool isImageOf(const pcl::PointCloud<PointT>& cloud, const Intrinsics& camera, double tolerance) {
  constexpr std::size_t kSamples = 10000;
  const auto step = std::max(std::uint32_t{1}, static_cast<std::uint32_t>(cloud.size() / kSamples));
  std::size_t in_place = 0, elsewhere = 0;
  for (std::uint32_t v = 0; v < cloud.height; ++v)
    for (std::uint32_t u = v % step; u < cloud.width; u += step) {
      const PointT& p = cloud[std::size_t(v) * cloud.width + u];
      if (!detail::inFront(p)) continue;
      const Eigen::Vector2d pixel = camera.project({p.x, p.y, p.z});
      ++((pixel - Eigen::Vector2d(u, v)).norm() <= tolerance ? in_place : elsewhere);
    }
  return in_place >= elsewhere;
}

template <typename PointT>
DepthImage depthImage(const pcl::PointCloud<PointT>& cloud, const Intrinsics& camera) {
  DepthImage image;
  image.camera = camera;
  image.depth.resize(cloud.size());
  std::transform(cloud.begin(), cloud.end(), image.depth.begin(),
                 [](const PointT& p) { return isMeasured(p.z) ? p.z : 0.f; });
  return image;
}

namespace detail {

/** \brief Do most points lie behind the camera, as in the axes of viewers? */
template <typename PointT>
bool isBehind(const pcl::PointCloud<PointT>& cloud) {
  const auto n = [&cloud](auto holds) { return std::count_if(cloud.begin(), cloud.end(), holds); };
  return n([](const PointT& p) { return p.z < -kNearestMeasured; }) >
         n([](const PointT& p) { return p.z > 0; });
}

template <typename PointT>
std::optional<Intrinsics> cameraOfInput(const pcl::PointCloud<PointT>* cloud, const pcl::Indices* indices,
                                        const Intrinsics& given, std::string& why_not) {
  const auto none = [&why_not](const char* why) -> std::optional<Intrinsics> {
    why_not = why;
    return {};
  };
  if (!cloud || cloud->empty()) return none("no input cloud");
  if (!isOrganized(*cloud))
    return none("the cloud is not organized; set a camera with intrinsics, which sees it from the origin");
  if (indices && !areIndicesOf(*cloud, *indices)) return none("the indices do not fit the cloud");
  const bool is_set = given != Intrinsics();
  if (is_set && !given.valid()) return none("the camera that was set is impossible");
  if (is_set && (given.width != int(cloud->width) || given.height != int(cloud->height)))
    return none("the camera that was set has not the size of the cloud");
  if (isBehind(*cloud))
    return none(
        "the points lie behind the camera: x right, y down, z forward is expected, and a cloud with y "
        "up and z backward has to be turned by 180 deg about x");
  if (is_set && !isImageOf(*cloud, given, kCalibrationError * given.width))
    return none("the points are not where the camera that was set sees them");
  const std::optional<Intrinsics> camera = is_set ? given : recoverIntrinsics(*cloud);
  if (!camera) return none("the camera of the cloud is not known and not to be had from its points");
  return camera;
}

/** \brief The depth image of points in any order. */
template <typename PointT>
DepthImage seenImage(const pcl::PointCloud<PointT>& cloud, const pcl::Indices* indices,
                     const Intrinsics& camera) {
  DepthImage image;
  image.camera = camera;
  image.depth.assign(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height), 0.f);
  const auto add = [&](const PointT& p) {
    const auto pixel = pixelOf(p, camera);
    if (!pixel) return;
    float& depth = image.depth[*pixel];
    if (depth == 0 || p.z < depth) depth = p.z;
  };
  if (indices)
    for (const auto i : *indices) add(cloud[static_cast<std::size_t>(i)]);
  else
    for (const PointT& p : cloud) add(p);
  return image;
}

/** \brief The depth image of points in any order, by the camera, or one with so much fewer pixels that the
 * points fill them. */
template <typename PointT>
std::optional<DepthImage> densestImage(const pcl::PointCloud<PointT>& cloud, const pcl::Indices* indices,
                                       const Intrinsics& camera, std::string& why_not) {
  constexpr int kMostStep = 16, kLeastWidth = 40;
  for (int step = 1; step == 1 || (step <= kMostStep && camera.width / step >= kLeastWidth); step *= 2) {
    DepthImage image = seenImage(cloud, indices, camera.subsampled(step));
    if (!indices && step == 1) fillHoleGrid(image);
    if (isDense(image)) return image;
  }
  why_not =
      "the points are too sparse: most have no neighbours within " + std::to_string(kMostStep) + " pixels";
  return {};
}

/** \brief Does the camera see most of the points? */
template <typename PointT>
bool seesMost(const pcl::PointCloud<PointT>& cloud, const pcl::Indices* indices, const Intrinsics& camera) {
  std::size_t seen = 0, finite = 0;
  const auto count = [&](const PointT& p) {
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) return;
    ++finite;
    seen += pixelOf(p, camera).has_value();
  };
  if (indices)
    for (const auto i : *indices) count(cloud[static_cast<std::size_t>(i)]);
  else
    for (const PointT& p : cloud) count(p);
  return 2 * seen >= finite;
}

}  // namespace detail

template <typename PointT>
std::optional<DepthImage> depthImageOfInput(const pcl::PointCloud<PointT>* cloud, const pcl::Indices* indices,
                                            const Intrinsics& given, std::string& why_not) {
  if (cloud && !cloud->empty() && !isOrganized(*cloud) && given.valid()) {
    if (indices && !areIndicesOf(*cloud, *indices))
      why_not = "the indices do not fit the cloud";
    else if (!detail::seesMost(*cloud, indices, given))
      why_not =
          "the cloud is not organized, and the camera that was set, at the origin of its coordinates, does "
          "not see most of its points";
    else
      return detail::densestImage(*cloud, indices, given, why_not);
    return {};
  }
  const std::optional<Intrinsics> camera = detail::cameraOfInput(cloud, indices, given, why_not);
  if (!camera) return {};
  DepthImage image = depthImage(*cloud, *camera);
  if (!indices) {
    fillHoleGrid(image);
    return image;
  }
  std::vector<float> chosen(image.depth.size(), 0.f);
  for (const auto i : *indices) chosen[i] = image.depth[i];
  image.depth.swap(chosen);
  if (isDense(image)) return image;
  return detail::densestImage(*cloud, indices, *camera, why_not);
}

}  // namespace facetloc
