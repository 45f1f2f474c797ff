// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>

namespace facetloc::internal {

/** \brief Does a view show by itself that its camera stands on the floor as mounted: the floor below it, or
 * something level above the floor, or two walls that are upright; and nothing that is level or upright but
 * for a few degrees? */
bool showsMounting(const View& view, const CameraMounting& mounting);

/** \brief How the camera of a view differs from that of a map or another view; a camera without mounting has
 * that of the map where the view shows it. */
CameraDifference differenceFrom(const Camera& of_map, const View& view);

}  // namespace facetloc::internal
