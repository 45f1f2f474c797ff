// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"

#include <facetloc/features/local_model.h>
#include <facetloc/io/output_lock.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace facetloc {

/** \brief Finds the mounting of the camera by the floor and writes it into a map file, unless it is known
 * already. Says so on console.out. Throws IoError. */
void completeMounting(const std::filesystem::path& map, const Console& console);

/** \brief Adds the missing parts of a map file: the place index of a large map, and its ambiguity.
 * \param threads 0 = all cores. Throws IoError, and Stopped at Ctrl-C. */
void completeMap(const std::filesystem::path& map, int threads, const Console& console);

/** \brief Writes a map that was not there, with all that it is asked for when it is opened. Throws UsageError
 * without a path, IoError. \param make is called once it is clear that the map can be written */
void writeNewMap(const std::string& path, bool overwrite, int threads, const Console& console,
                 const std::function<const Map&()>& make);

/** \brief Locks the file that a map is to be written to. Throws IoError if it exists and may not be replaced.
 */
OutputLock lockTarget(const std::filesystem::path& map, bool may_replace);

/** \brief Writes a map in the place of one that was there, which stays as it was until the new one is
 * complete. Throws IoError, and Stopped at Ctrl-C. */
void replaceWholeMap(const std::filesystem::path& path, const Map& map, int threads, const Console& console);

/** \brief The faults of the place index in a map file, in words; empty if it is sound or missing. */
std::vector<std::string> placeIndexFaults(const std::filesystem::path& map);

}  // namespace facetloc
