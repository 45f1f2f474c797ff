// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "ranking/global_localization.h"

#include <facetloc/mapping/map_session.h>

namespace facetloc::internal {

/** \brief Finds a trajectory in a map: its keyframes are localized, of the sure answers the largest set is
 * taken in which all agree on one place, and the trajectory is bent to them in a pose graph, in which the map
 * stays as it is (METHOD 1.5). The same for any number of threads. */
SessionPlace placeInMap(const GlobalLocalization& localization, const CameraTrajectory& trajectory,
                        const MapSessionParams& params, int threads = 1,
                        const MapProgressCallback& progress = {});

/** \brief The same for a trajectory whose shape is known, such as another map's: it moves as a whole. Where
 * the two agree within the tolerance as they are, it stays where it is.
 * \param accuracy of its poses, relative to each other */
SessionPlace placeRigidly(const GlobalLocalization& localization, const CameraTrajectory& trajectory,
                          const MapBuilderParams& accuracy, const MapSessionParams& params, int threads = 1,
                          const MapProgressCallback& progress = {});

}  // namespace facetloc::internal
