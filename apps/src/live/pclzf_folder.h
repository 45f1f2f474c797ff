// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

namespace facetloc {

/** \brief Is it a folder of PCL's compressed images (.pclzf)? */
bool isPclzfFolder(const std::filesystem::path& path);

/** \brief Throws IoError, which names the file, unless PCL's grabber survives the folder: it trusts the names
 * of its files to tell a time, their headers to tell the truth, and the n-th .xml to be the camera of the
 * n-th depth image. */
void requireSoundPclzfFolder(const std::filesystem::path& folder);

}  // namespace facetloc
