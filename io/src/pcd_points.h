// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "pcd_header.h"

#include <pcl/PCLPointCloud2.h>

#include <filesystem>

namespace facetloc {

/** \brief The points of a PCD file with a sound header, as PCL reads them. Throws IoError. */
pcl::PCLPointCloud2 readPcd(const std::filesystem::path& path, const PcdHeader& header);

/** \brief Writes points as a binary_compressed PCD, atomically. Throws IoError. */
void writePcd(const std::filesystem::path& path, const pcl::PCLPointCloud2& points);

}  // namespace facetloc
