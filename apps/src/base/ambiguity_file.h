// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/app.h"

#include <filesystem>

namespace facetloc {

/** \brief Asks a map about itself, how much alike its places look, and writes the answer into its file,
 * unless it is there already or the map has no poses. \param threads 0 = all cores. Throws IoError, and
 * Stopped at Ctrl-C. */
void writeAmbiguity(const std::filesystem::path& map, int threads, const Console& console);

}  // namespace facetloc
