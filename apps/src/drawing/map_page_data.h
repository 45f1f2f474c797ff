// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/map_page.h"

#include <json/value.h>

namespace facetloc {

/** \brief The data for apps/pages/map.js. Throws IoError, with the name of the page that was to be, if no
 * local model of the map has a pose. */
Json::Value mapPageData(const Map& map, const MapPage& page, const std::filesystem::path& path);

}  // namespace facetloc
