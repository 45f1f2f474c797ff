// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "hits.h"

#include <vector>

/** \file
 * Errors of a depth camera that depend on the surroundings of a pixel. */

namespace facetloc {

/** \brief The surfaces as a stereo camera sees them: nearer ones grow by `px` pixels, since its matching
 * window sees them first. */
std::vector<int> fattened(const Hits& hits, const Intrinsics& camera, double px);

/** \brief How much of its light a pixel gets by way of another surface, in [0, 1]: 1 in the edge where two
 * surfaces meet, 0 from 0.3 m on. Light that comes round a corner has a longer way. */
double cornerShare(const Hits& hits, const Intrinsics& camera, int u, int v);

/** \brief Depths [m] (0 = nothing seen) as a window sees them: means of the inverse depths seen around,
 * weighted by a Gaussian of that standard deviation. Planes stay planes, silhouettes become ramps. */
std::vector<double> blurred(const std::vector<double>& depth, const Intrinsics& camera, double px);

/** \brief Depths without holes: pixels within `px` of silhouettes and those not seen are
 * interpolated between the others. Where nothing is seen at all, nothing is invented. */
std::vector<double> filledIn(const std::vector<double>& depth, const Intrinsics& camera, double px);

}  // namespace facetloc
