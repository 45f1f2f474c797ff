// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <ostream>

namespace facetloc {

/** \brief Creates a folder and those above it, if they are not there. Throws IoError. */
void createFolders(const std::filesystem::path& folder);

/** \brief Writes a file so that it is there whole or not at all: path.tmp, then renamed.
 *
 * \param write gets the path of the temporary file and writes it. Throws IoError if that fails (full disk,
 * missing folder); the temporary file is then removed and an older file at path is untouched. */
void writeAtomically(const std::filesystem::path& path,
                     const std::function<void(const std::filesystem::path& temporary)>& write);

/** \brief The same for text: write fills a stream in the classic locale; a stream that went bad is an
 * IoError. */
void writeTextAtomically(const std::filesystem::path& path, const std::function<void(std::ostream&)>& write);

}  // namespace facetloc
