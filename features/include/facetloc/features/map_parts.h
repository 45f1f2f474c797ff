// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>

#include <cstddef>
#include <vector>

/** \file
 * A map whose links say more than its poses: where models are that have no pose of their own. Several maps
 * that are one. */

namespace facetloc {

/** \brief How uncertain a link is: the variance of where a point lies that the second camera sees 3 m away
 * [m^2]. The same both ways. */
double uncertaintyOf(const Link& link);

/** \brief Gives all local models of a map a pose, by its links where none was given, and the map its parts.
 *
 * Models with a given pose keep it; they are the world. Along links, over the path with the
 * least sum of uncertainties, each other model gets its pose from the nearest of them. Models that no path
 * joins with the world form parts of their own, each joined by links, and with the name of its first model,
 * which stands as the mounting of the map's camera says, over the origin, or has its camera in the origin
 * where no mounting is known. If no pose was given and all models are connected, that one part is the world.
 *
 * Links that lead nowhere or are not finite do not count. Doing it again, after a change of models, links or
 * mounting, begins anew with the given poses. */
void placeByLinks(Map& map);

/** \brief Was any pose given? Then part 0 is the world, and lies as those poses say. */
bool hasGivenPose(const Map& map);

/** \brief How many local models are in each part, and how many of these have their pose by links. */
struct PartCount {
  std::size_t models = 0;
  std::size_t by_links = 0;
};
/** \brief Counts by index of the part. */
std::vector<PartCount> partCounts(const Map& map);

/** \brief The part to show where only one can be shown: the world, or else the first of those with most local
 * models. */
int mainPart(const Map& map);

/** \brief Several maps as one, for localization in all of them at once: floors, buildings, cameras.
 *
 * Their parts stay parts, each in its own frame, with the name of their map, and after a slash the name of
 * the part if it is not the world; local models are named likewise. Views are shared, not copied. Each part
 * keeps the ambiguity of its map; the errors that views share are the largest of all, the threshold of sure
 * answers the highest. The camera is the first map's, without mounting if another has another one: a
 * camera in the hand. Throws std::invalid_argument for no map, names that are empty, hold a slash or occur
 * twice, and for surfaces of different kinds (MapSurfaces). */
Map joinMaps(std::vector<JoinedMap> maps);

}  // namespace facetloc
