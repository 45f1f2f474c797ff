// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl/PolygonMesh.h>

#include <filesystem>

namespace facetloc {

/** \brief Reads an .stl file, text or binary. Corners at the same position are one point. Throws IoError. */
pcl::PolygonMesh readStl(const std::filesystem::path& path);

}  // namespace facetloc
