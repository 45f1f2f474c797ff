// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl/PolygonMesh.h>

#include <filesystem>
#include <ostream>

namespace facetloc {

// Own reader and writer, as PCL's are in libpcl_io, which brings VTK along.

/** \brief Reads a PLY file, of text or binary: the positions of its vertices, as doubles, and its faces, if
 * it has some. Throws IoError for a file that is not PLY, has no positions, or ends before the data that its
 * header promises. */
pcl::PolygonMesh readPly(const std::filesystem::path& path);

/** \brief Writes a binary PLY file of positions (x, y, z as floats), of colours if there are some (rgb), and
 * of faces. */
void writePly(std::ostream& out, const pcl::PolygonMesh& mesh);

}  // namespace facetloc
