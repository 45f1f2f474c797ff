// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/pose.h>

#include <vector>

namespace facetloc::internal {

/** \brief A place where a camera may be. */
struct LikelyPlace {
  PoseWithCovariance T_w_c;
  double probability = 0;
  int part = 0;  ///< of the map, in whose frame the pose is
};

/** \brief What two views in a row say together: what one of them leaves open the other may tell.
 *
 * Bayes' rule. What one list does not have is given the rest of its probability, spread over all local
 * models. That the place is in neither list is not as unlikely as for independent views: those in a row look
 * alike.
 *
 * \param before places of the view before, moved to where the camera is now
 * \param now places of the view, each once; the probabilities of both are at most 1 in all
 * \param models local models of the map, at least 1
 * \return the places of both, those of `now` first in their order; within 0.2 m and 3 deg is one place.
 * Those that have become less probable than one in a million are left out. */
std::vector<LikelyPlace> placesOfBoth(const std::vector<LikelyPlace>& before,
                                      const std::vector<LikelyPlace>& now, int models);

}  // namespace facetloc::internal
