// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "sessions/map_review.h"

#include <vector>

namespace facetloc::internal {

/** \brief Removes local models from a map, and the links that lead to them. */
void removeModels(const std::vector<char>& removed, Map& map);

/** \brief MapSession::update() with images in their places. \param review of the map as it is */
MapChanges updateMap(Map& map, const std::vector<SessionImage>& session, const MapReview& review,
                     const MapBuilderParams& builder = {}, const MapSessionParams& params = {});

}  // namespace facetloc::internal
