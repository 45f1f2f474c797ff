// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/command_line.h"

#include <filesystem>
#include <string>
#include <vector>

/** \file
 * Output folders, so that files of others are neither replaced nor mixed with results. */

namespace facetloc {

/** \brief The files by which a folder of facetloc_localize and facetloc_live is known, be it unfinished. */
const std::vector<std::string>& marksOfResults();

/** \brief --overwrite, of tools that write to a folder. */
void addOverwrite(CommandLine& line, bool& overwrite);

/** \brief Creates an output folder, or takes one that is there. Hidden files and subfolders do not count.
 * Throws IoError, which names the folder and a file in it, if it holds files and none of the tool's own.
 * \param marks names of files, each of which shows that the tool has written to the folder before
 * \param overwrite take it in any case */
void claimFolder(const std::filesystem::path& folder, const std::vector<std::string>& marks, bool overwrite);

/** \brief The same for a folder of pictures, which may hold other pictures only. */
void claimPictureFolder(const std::filesystem::path& folder, bool overwrite);

}  // namespace facetloc
