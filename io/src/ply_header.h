// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

namespace facetloc {

/** \brief Throws IoError unless the file begins with the header of a PLY file and is large enough for all
 * that its header promises: PCL allocates that before it reads. */
void requireSoundPly(const std::filesystem::path& path);

}  // namespace facetloc
