// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/pictures.h"

#include <string>
#include <vector>

namespace facetloc {

/** \brief drawFloorMap() as a figure of an HTML page: the upright segments of all local models from above,
 * runs as lines, marks as disks that carry the headings, a scale bar, and a legend in words with their
 * numbers. Of more than 20 000 segments the longest are drawn. Throws IoError if no local model of the map
 * has a pose. */
std::string svgFloorMap(const Map& map, const std::vector<DrawnRun>& runs,
                        const std::vector<DrawnMarks>& marks, const std::string& caption);

}  // namespace facetloc
