// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/map_page.h"
#include "evaluation/evaluation.h"

#include <vector>

namespace facetloc {

/** \brief Results as they are shown in their map: the answers of all runs in their order, those of the part
 * of the map that is drawn with their places. Without runs in it, and without a title. Throws
 * std::runtime_error for an answer in a local model that the map has not. \param evaluation of these results;
 * null if nothing is known to be true \param relative whether errors relative to local models decide which
 * answers are right */
MapPage answerPage(const Map& map, const std::vector<RunResults>& runs,
                   const Evaluation* evaluation = nullptr, bool relative = false);

}  // namespace facetloc
