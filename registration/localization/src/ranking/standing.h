// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>

namespace facetloc::internal {

/** \brief Does a view show by itself that its camera stands on the floor as mounted: the floor below it, or
 * something level above the floor, or two walls that are upright; and nothing that is level or upright but
 * for a few degrees? */
bool showsMounting(const View& view, const CameraMounting& mounting);

}  // namespace facetloc::internal
