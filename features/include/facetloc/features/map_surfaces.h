// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>

namespace facetloc {

/** \brief Key of a map's meta data: "fixed" or "incomplete", as MapSurfaces; without it, surfaces were seen.
 */
constexpr const char* kSurfacesKey = "surfaces";

/** \brief The surfaces that a map holds (localization/METHOD 11.7). */
enum class MapSurfaces {
  seen,        ///< as a camera or scanner saw them: all surfaces of a day, some of which people move
  fixed,       ///< as drawn: the surfaces that stay; people put other things before them
  incomplete,  ///< a part of the surfaces that stay, as the walls of a floor plan; furniture stands before
               ///< them
};

/** \brief The kind of surfaces in a map. */
MapSurfaces surfacesOf(const Map& map);
/** \brief Says so in the meta data of a map. */
void setSurfaces(MapSurfaces surfaces, Map& map);

/** \brief Whether a map lacks surfaces: objects in front of its surfaces, as furniture before a wall,
 * do not contradict it; objects seen through them do (localization/METHOD 11.7). */
inline bool lacksSurfaces(const Map& map) { return surfacesOf(map) == MapSurfaces::incomplete; }
/** \brief Says so in the meta data of a map. */
inline void setLacksSurfaces(Map& map) { setSurfaces(MapSurfaces::incomplete, map); }

}  // namespace facetloc
