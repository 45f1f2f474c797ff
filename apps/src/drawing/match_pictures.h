// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/pictures.h"

#include <facetloc/io/png.h>

namespace facetloc {

/** \brief Throws std::invalid_argument for an image without pixels or with labels of another size. */
void checkDrawable(const SeenImage& image);

/** \brief The picture that drawMatches() writes. */
Raster<std::uint8_t> matchesPicture(const SeenImage& query, const Map& map,
                                    const std::vector<DrawnMatch>& answers);

}  // namespace facetloc
