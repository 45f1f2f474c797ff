// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <pcl/PCLPointCloud2.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace facetloc::internal {

/** \brief The positions of the points of a cloud, whatever its other fields are. */
class ModelPoints {
public:
  /** \brief Throws std::invalid_argument unless there are fields x, y, z of floats, and data for all points.
   * \param cloud is borrowed */
  explicit ModelPoints(const pcl::PCLPointCloud2& cloud);

  std::size_t size() const { return size_; }
  Eigen::Vector3f operator[](std::size_t i) const;

private:
  const pcl::PCLPointCloud2& cloud_;
  std::array<std::size_t, 3> offsets_{};
  std::size_t size_;
};

/** \brief Throws std::invalid_argument for bounds whose coordinates are too large for floats to resolve
 * millimetres. */
void requireResolved(const Eigen::AlignedBox3d& bounds);

/** \brief Triangles of a polygon, as indices of its corners, in the polygon's direction of rotation.
 *
 * A fan from the first corner where it stays within the polygon, as in every convex one; else by ear clipping
 * in the plane of Newell's normal. Corners may be collinear, or be there twice, as where a cut leads to a
 * hole. A fan again for polygons that cross themselves, and for those of more than 10 000 corners
 * (METHOD 3.1). \param corners finite */
std::vector<std::array<std::uint32_t, 3>> polygonTriangles(const std::vector<Eigen::Vector3f>& corners);

}  // namespace facetloc::internal
