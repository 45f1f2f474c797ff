// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "hits.h"

#include <vector>

/** \file
 * Errors of a depth camera that depend on what is seen around a pixel. */

namespace facetloc {

/** \brief The surfaces as a stereo camera sees them: nearer ones grow by so many pixels, since its matching
 * window sees them first. */
std::vector<int> fattened(const Hits& hits, const Intrinsics& camera, double px);

/** \brief How much of its light a pixel gets by way of another surface, in [0, 1]: 1 in the edge where two
 * surfaces meet, 0 from 0.3 m on. Light that comes round a corner has a longer way. */
double cornerShare(const Hits& hits, const Intrinsics& camera, int u, int v);

}  // namespace facetloc
