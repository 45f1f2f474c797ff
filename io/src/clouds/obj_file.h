// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl/PolygonMesh.h>

#include <filesystem>

namespace facetloc {

/** \brief The vertices and faces of a Wavefront OBJ file, without its normals, textures and materials. Faces
 * may have vertices that are not there. Throws IoError with the line that cannot be read. */
pcl::PolygonMesh readObj(const std::filesystem::path& path);

}  // namespace facetloc
