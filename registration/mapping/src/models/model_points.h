// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <pcl/PCLPointCloud2.h>

#include <array>
#include <cstddef>
#include <string>

namespace facetloc::internal {

/** \brief Three fields of floats of a cloud, such as x, y, z, whatever its other fields are. */
class PointTriples {
public:
  /** \brief Throws std::invalid_argument if a field is missing or no float, or if there is less data than
   * points. \param cloud is borrowed */
  PointTriples(const pcl::PCLPointCloud2& cloud, const std::array<std::string, 3>& names);
  /** \brief Does the cloud have such fields? */
  static bool areIn(const pcl::PCLPointCloud2& cloud, const std::array<std::string, 3>& names);

  std::size_t size() const { return size_; }
  Eigen::Vector3f operator[](std::size_t i) const;

private:
  const pcl::PCLPointCloud2& cloud_;
  std::array<std::size_t, 3> offsets_{};
  std::size_t size_;
};

/** \brief The position fields of a cloud. */
inline const std::array<std::string, 3> kPosition{"x", "y", "z"};
/** \brief Its normals. */
inline const std::array<std::string, 3> kNormal{"normal_x", "normal_y", "normal_z"};

/** \brief Throws std::invalid_argument for bounds whose coordinates are too large for floats to resolve
 * millimetres. */
void requireResolved(const Eigen::AlignedBox3d& bounds);

}  // namespace facetloc::internal
