// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/types.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>

namespace facetloc {

/** \brief Intrinsics of an organized cloud, recovered from its points: x/z is linear in the column, y/z in
 * the row. Empty if the cloud is unorganized, has fewer than 16 finite points of measured depth (isMeasured),
 * does not spread over columns and rows, or is not the image of a pinhole camera (residual above 1 px in the
 * median). */
template <typename PointT>
std::optional<Intrinsics> recoverIntrinsics(const pcl::PointCloud<PointT>& cloud);

/** \brief True if the camera sees most points of an organized cloud where they are in it, within a few
 * pixels. Also true for a cloud without points. */
template <typename PointT>
bool isImageOf(const pcl::PointCloud<PointT>& cloud, const Intrinsics& camera, double tolerance);
/** \brief Share of the width by which a better calibration moves the pixels of a cloud at most; one that was
 * transformed is off by more. */
constexpr double kCalibrationError = 0.02;

/** \brief True for a cloud of several rows and columns with one point for each. */
template <typename PointT>
bool isOrganized(const pcl::PointCloud<PointT>& cloud) {
  return cloud.height > 1 && cloud.width > 1 && cloud.size() == std::size_t(cloud.width) * cloud.height;
}

/** \brief True if all indices lie in the cloud; PCL itself does not look. */
template <typename PointT>
bool areIndicesOf(const pcl::PointCloud<PointT>& cloud, const pcl::Indices& indices) {
  return std::all_of(indices.begin(), indices.end(),
                     [n = cloud.size()](auto i) { return i >= 0 && std::size_t(i) < n; });
}

/** \brief The depth image of an organized cloud: z of every point, 0 where isMeasured() says no. */
template <typename PointT>
DepthImage depthImage(const pcl::PointCloud<PointT>& cloud, const Intrinsics& camera);

/** \brief The pixel, row-major, at which a camera at the origin sees a point; nothing for points that were
 * not measured or lie outside of its image. */
template <typename PointT>
std::optional<std::size_t> pixelOf(const PointT& p, const Intrinsics& camera) {
  if (!std::isfinite(p.x) || !std::isfinite(p.y) || !isMeasured(p.z)) return std::nullopt;
  const Eigen::Vector2d q = camera.project({p.x, p.y, p.z});
  if (!(q.x() > -0.5 && q.y() > -0.5 && q.x() < camera.width - 0.5 && q.y() < camera.height - 0.5))
    return std::nullopt;
  return static_cast<std::size_t>(std::lround(q.y())) * static_cast<std::size_t>(camera.width) +
         static_cast<std::size_t>(std::lround(q.x()));
}

/** \brief The depth image of a PCL class's input, restricted to the indices if there are any. Its camera is
 * the given one; if nothing is set, the camera is recovered from the points. Of a whole cloud, a grid of
 * holes is filled (depth_image.h): points without coordinates may have depth in the image.
 *
 * A cloud that is not organized, as after a filter, is seen by the given camera from the origin of its
 * coordinates: each pixel has the depth of its nearest point (pixelOf()). Where points or indices are so
 * sparse that most pixels would be empty, as after a VoxelGrid, the image has a 2nd, 4th, 8th or 16th of the
 * columns and rows.
 *
 * \param cloud, indices may be null
 * \param why_not receives a sentence if the result is empty: there is no cloud, or an unorganized one
 * without a camera, outside of its image or too sparse, the indices do not fit it, or the camera is
 * impossible, of another size, not to be had from the points, or does not see them where they are */
template <typename PointT>
std::optional<DepthImage> depthImageOfInput(const pcl::PointCloud<PointT>* cloud, const pcl::Indices* indices,
                                            const Intrinsics& given, std::string& why_not);

}  // namespace facetloc

#include <facetloc/features/impl/organized_cloud.hpp>

namespace facetloc {
extern template std::optional<Intrinsics> recoverIntrinsics(const pcl::PointCloud<pcl::PointXYZ>&);
extern template std::optional<Intrinsics> recoverIntrinsics(const pcl::PointCloud<pcl::PointXYZI>&);
extern template std::optional<Intrinsics> recoverIntrinsics(const pcl::PointCloud<pcl::PointXYZRGB>&);
extern template std::optional<Intrinsics> recoverIntrinsics(const pcl::PointCloud<pcl::PointXYZRGBA>&);
extern template DepthImage depthImage(const pcl::PointCloud<pcl::PointXYZ>&, const Intrinsics&);
extern template DepthImage depthImage(const pcl::PointCloud<pcl::PointXYZI>&, const Intrinsics&);
extern template DepthImage depthImage(const pcl::PointCloud<pcl::PointXYZRGB>&, const Intrinsics&);
extern template DepthImage depthImage(const pcl::PointCloud<pcl::PointXYZRGBA>&, const Intrinsics&);
}  // namespace facetloc
