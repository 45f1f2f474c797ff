// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>

namespace facetloc::internal {

/** \brief Does a view on its own show that its camera stands on the floor as mounted: the floor below it, or
 * something level above the floor, or two walls that are upright; and nothing that is level or upright but
 * for a few degrees? Where gravity was measured, it decides, unless planes contradict the mounting. */
bool showsMounting(const View& view, const CameraMounting& mounting);

/** \brief Difference between the camera of a view and a map's, or another view's. Where the view shows the
 * mounting of the map's camera, a camera without mounting counts as mounted like it. */
CameraDifference differenceFrom(const Camera& of_map, const View& view);

}  // namespace facetloc::internal
