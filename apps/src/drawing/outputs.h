// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

/** \file
 * Outputs of the tools never replace a recording. */

namespace facetloc {

/** \brief Throws UsageError if a folder of results is the folder of the images. */
void requireOtherFolder(const std::filesystem::path& results, const std::filesystem::path& images);

/** \brief Throws UsageError if a file is there already, unless it is a picture, as one that the tools draw
 * may be: a PNG of 16 bits is a depth image or labels. */
void requireNoneButPicture(const std::filesystem::path& path);

}  // namespace facetloc
