// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/simulation/simulated_scene.h>

#include <cstdint>
#include <string>
#include <vector>

namespace facetloc {

/** \brief A place on a robot's way, and its actions there before it goes on straight to the next one. */
struct Waypoint {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  ///< [m]
  double look_deg = 0;  ///< turns on the spot by this angle, to the left if positive
};

/** \brief A way that a robot drives again and again: from the last waypoint it goes on to the first. */
using Route = std::vector<Waypoint>;

/** \brief Convex outline of something solid in the floor plan, counterclockwise [m]. */
using PlanOutline = std::vector<Eigen::Vector2d>;

/** \brief A whole floor as it is when a robot maps it, and as it is later: some furniture and doors have
 * moved.
 *
 * A plane that is the same in both has the same id; moved planes have new ones. */
struct SimulatedPlace {
  Scene mapped;  ///< when the map is made
  Scene later;   ///< when the robot comes back
  Route mapping_route;
  Route query_route;                                ///< another line through the same places
  std::vector<Eigen::AlignedBox2d> unmapped_rooms;  ///< on the query route only
  std::vector<PlanOutline> walls;                   ///< and pillars, as a floor plan shows them
  std::vector<PlanOutline> doorways;                ///< openings of the walls that begin at the floor
  bool one_way = false;                             ///< the routes end at their last waypoints
};

/** \brief The names of the places that there are: office, home, hall, corridor, hotel, boards, doors, box. */
const std::vector<std::string>& simulatedPlaceNames();
/** \brief The place of that name, generated from the seed; the same seed gives the same place. Throws
 * std::invalid_argument for an unknown name.
 *
 * - office: a loop of corridors with doors in recesses, some of them ajar, windows, pillars, beams,
 *   cupboards, bins and notice boards, all equal on purpose, and a few rooms that are open.
 * - home: furnished rooms.
 * - hall: shelves, columns and large distances.
 * - corridor: 40 m long and bare, driven along once: but for its ends, out of range for most of the way,
 *   no surface reveals how far along it a camera is.
 * - hotel: twelve rooms off one corridor, equal inside; doors and the things beside them differ.
 * - boards: a bare floor with some flat boards, driven over; nothing else is in sight. For a camera that
 *   looks down.
 * - doors: a corridor driven along once, with closed doors every 1.8 m, all equal, and three things that
 * stand beside them.
 * - box: a cabinet on a bare floor, driven around, which looks the same from opposite sides. */
SimulatedPlace simulatedPlace(const std::string& name, std::uint64_t seed);

}  // namespace facetloc
