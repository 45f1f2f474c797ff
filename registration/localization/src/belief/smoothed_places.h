// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/localization/localizer.h>

namespace facetloc::internal {

/** \brief The places of a view by the views up to it and by those from the next one on (METHOD 16.7): most
 * probable first, with `nowhere` and `looks`; state and reason are left to the caller.
 * \param prior log odds that the map holds a place, which both answers have in them [nats] */
Localization smoothedPlaces(const Localization& until_now, const Localization& from_next,
                            const PoseWithCovariance& T_now_next, double prior);

}  // namespace facetloc::internal
