// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"

#include <filesystem>
#include <string>
#include <vector>

/** \file
 * Output folders and files, so that those of others are neither replaced nor mixed with results, and own
 * ones not without a word. */

namespace facetloc {

/** \brief The files by which a folder of facetloc_localize and facetloc_live is known, be it unfinished. */
const std::vector<std::string>& marksOfResults();

/** \brief --overwrite, of tools that write to a folder. */
void addOverwrite(CommandLine& line, bool& overwrite);

/** \brief Creates an output folder, or takes one that is there. Hidden files and subfolders do not count.
 * Throws IoError, which names the folder and a file in it, if it holds files and none of the tool's own.
 * \param marks names of files, each of which shows that the tool has written to the folder before
 * \param overwrite take it in any case
 * \param console receives a remark that files of an earlier run are replaced; null if they stay */
void claimFolder(const std::filesystem::path& folder, const std::vector<std::string>& marks, bool overwrite,
                 const Console* console);

/** \brief The same for a folder of pictures, which may hold other pictures only. */
void claimPictureFolder(const std::filesystem::path& folder, bool overwrite);

/** \brief Throws UsageError if a file is there already, unless it is a picture, or a page of the tools. */
void requireReplaceable(const std::filesystem::path& path);

}  // namespace facetloc
