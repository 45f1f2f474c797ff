// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>
#include <facetloc/mapping/map_image.h>
#include <facetloc/mapping/map_session.h>

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace facetloc {

/** \brief Where a map is in the maps before it. */
struct MapAlignment {
  /// Maps that it was looked for in, and the result; the last one has found it, if any has. Empty for the
  /// first map, for a map without poses, and where no map before it has poses.
  std::vector<std::pair<std::size_t, SessionPlace>> tried;
  bool moved = false;                                           ///< false where it agrees as it is
  Eigen::Isometry3d T_new_old = Eigen::Isometry3d::Identity();  ///< change of its world

  bool isLost() const { return !tried.empty() && !tried.back().second.found(); }
};

/** \brief Moves the maps behind the first one to where their views are found in the maps before them, so that
 * all share one world; maps that agree as they are stay where they are. Maps without poses are left alone.
 * \param threads 0 = all cores
 * \return an alignment of each map; it ends with the first one that is lost. */
std::vector<MapAlignment> alignMaps(std::vector<Map>& maps, int threads = 1,
                                    const MapProgressCallback& progress = {});

/** \brief One map of several that share a world: models in the order of the maps, links kept, and models
 * without a pose placed by their links. Names that occur more than once, and all keys of meta data, get the
 * name of their map in front; if one lacks surfaces, the merged one does. The camera is the first map's, with
 * the first distortion that any map has, and a mounting if all agree on it. \param names one per map. Throws
 * std::invalid_argument if names of local models still collide. */
Map mergedMap(const std::vector<Map>& maps, const std::vector<std::string>& names);

}  // namespace facetloc
