// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>

#include <Eigen/Geometry>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

/** \file
 * Organized clouds that are not as a camera sees them: in other axes, in millimetres, moved by their
 * viewpoint, with rows from the bottom up, or on the grid of an image with lens distortion. Private to io. */

namespace facetloc::internal {

/** \brief A cloud as it is in its file. */
struct FileCloud {
  pcl::PointCloud<pcl::PointXYZ> points;
  Eigen::Isometry3d viewpoint = Eigen::Isometry3d::Identity();  ///< as the header says
};

/** \brief The depth image of a cloud, and the changes made to its points: a sentence without full stop, or
 * nothing. */
struct CloudImage {
  DepthImage image;
  std::string remark{};
  std::vector<std::uint32_t> pixels{};  ///< pixel of each point; kNoPixel outside the image. Empty: in order
};
constexpr std::uint32_t kNoPixel = std::numeric_limits<std::uint32_t>::max();

/** \brief The image of a camera at the origin of the points; where that does not fit, of the points in other
 * axes, which a signed permutation turns into x right, y down, z forward, or of the points before their
 * viewpoint moved them; on a grid that a lens has bent, the points are sorted into a pinhole grid. Empty if
 * nothing fits. \param camera that the points have to be those of, if it is known */
std::optional<CloudImage> imageOf(const FileCloud& cloud, const std::optional<Intrinsics>& camera);

/** \brief The same of an organized PCD file. Throws IoError. */
CloudImage imageOfPcd(const std::filesystem::path& path, const std::optional<Intrinsics>& camera);

}  // namespace facetloc::internal
