// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/app.h"

#include <facetloc/features/local_model.h>
#include <facetloc/mapping/map_session.h>

#include <string>
#include <vector>

namespace facetloc {

/** \brief Moves the maps behind the first one to where their views are found in the maps before them, so that
 * all share one world; maps that agree as they are stay where they are. Maps without poses are left alone.
 * Prints what it has found. \param paths of the maps, for messages \param threads 0 = all cores
 * Throws IoError for a map whose views nothing before it shows. */
void alignMaps(std::vector<Map>& maps, const std::vector<std::string>& paths, int threads,
               const Console& console);

}  // namespace facetloc
