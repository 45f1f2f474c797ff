// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "clouds/pcd_header.h"

#include <Eigen/Geometry>
#include <pcl/PCLPointCloud2.h>

#include <filesystem>

namespace facetloc {

// Own reader and writer, as PCL's are in libpcl_io, which brings VTK along.

/** \brief The points of a PCD file with a sound header, packed, whatever the locale of the program is. Throws
 * IoError. \param viewpoint receives the pose of the sensor that the header says, if not null */
pcl::PCLPointCloud2 readPcd(const std::filesystem::path& path, const PcdHeader& header,
                            Eigen::Isometry3d* viewpoint = nullptr);

/** \brief Writes points, or none, as a binary_compressed PCD, atomically. Throws IoError. */
void writePcd(const std::filesystem::path& path, const pcl::PCLPointCloud2& points);

}  // namespace facetloc
