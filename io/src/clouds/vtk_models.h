// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl/PolygonMesh.h>

#include <filesystem>

namespace facetloc {

// VTK reads meshes of formats of its own. It is large: of shared libraries, the part that needs it is a
// module which is loaded when such a file is to be read, and which may be missing.

/** \brief Reads an .stl or .vtp file. Throws IoError if VTK complains or the module is missing.
 */
pcl::PolygonMesh readByVtk(const std::filesystem::path& path);

/** \brief The function of the module: reads the file into the mesh. Throws IoError. */
using VtkModelReader = void(const std::filesystem::path& path, pcl::PolygonMesh& mesh);
extern "C" void facetlocReadByVtk(const std::filesystem::path& path, pcl::PolygonMesh& mesh);

}  // namespace facetloc
