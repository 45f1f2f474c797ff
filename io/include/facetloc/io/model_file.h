// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl/PolygonMesh.h>

#include <filesystem>

namespace facetloc {

/** \brief Reads a scan or mesh: a .ply, .obj or .stl mesh, or, as a mesh without polygons, a .ply or .pcd
 * cloud. Of points, the positions are kept, as pcl::PointXYZ. They may be NaN, and indices of
 * polygons are not checked: surfaces leave such things out. Throws IoError for a file that is no such model,
 * promises more than it holds, or has no point. \param metres_per_unit factor of all coordinates. Throws
 * std::invalid_argument unless it is positive and finite */
pcl::PolygonMesh readModel(const std::filesystem::path& path, double metres_per_unit = 1);

}  // namespace facetloc
