// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>

#include <vector>

namespace facetloc {

/** \brief Key of a map's meta data: the names of the local models that were rendered from the depth pictures
 * of others (mapping's densify()), one a line. Names that no local model has mean nothing. */
constexpr const char* kRenderedKey = "rendered views";

/** \brief Flags the local models that were rendered: these views show nothing that others have not shown. */
std::vector<char> renderedViews(const Map& map);

}  // namespace facetloc
