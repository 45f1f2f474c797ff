// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>

namespace facetloc {

/** \brief Key of a map's meta data: "incomplete" for a map of a part of the surfaces only, as of the walls of
 * a floor plan. */
constexpr const char* kSurfacesKey = "surfaces";

/** \brief Whether a map lacks surfaces: objects in front of its surfaces, as furniture before a wall,
 * do not contradict it; objects seen through them do (localization/METHOD 11.7). */
bool lacksSurfaces(const Map& map);
/** \brief Says so in the meta data of a map. */
void setLacksSurfaces(Map& map);

}  // namespace facetloc
