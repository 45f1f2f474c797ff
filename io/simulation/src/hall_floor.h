// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "floor_plan.h"
#include "furniture.h"
#include "scene_builder.h"

#include <facetloc/features/pose.h>

#include <cstdint>
#include <vector>

namespace facetloc {

/** \brief A store: in the west two aisles between rows of racks, all equal but for the goods on them, and a
 * third one along a double row; in the east an open area with gates, machines and pallets, and a store room,
 * which is shut when the map is made.
 *
 *     +-------------------------------+
 *     |  machines and benches         |
 *     |            aisle 3            |
 *     | ==============                g
 *     | ==============   pallets      |
 *     |            aisle 2            |
 *     | ==============                g
 *     | ==============        +-------+
 *     |            aisle 1    | store |
 *     | ==============        | room  |
 *     +-----------------------+-------+
 *
 * Half of the halls are mirrored. */
class HallFloor : FurnishedFloor {
public:
  explicit HallFloor(std::uint64_t seed) : FurnishedFloor(seed, kFurniture) {}

  SimulatedPlace build();

private:
  enum Purpose : std::uint64_t { kSizes, kWays, kRacks, kFurniture };

  // Lengths in metres.
  static constexpr double kInnerWall = 0.14;   // thickness of the store room's walls
  static constexpr double kBackToBack = 0.12;  // between the two racks of a double row

  // ---- Sizes and ways (hall_floor.cpp) ----
  void drawSizes();
  /** The two ways pass the same places on different lines; only doors leave no choice. */
  void drawRoutes();

  // ---- Walls, gates and doors, columns and beams (hall_walls.cpp) ----
  /** A roller gate in its opening, of slats that jut out by turns. */
  void buildGate(const Spot& inside);
  void shutDoor(const Spot& inside);
  /** A wall of the hall, its inner face from corner to corner, inside to the left, with gates, doors, and
   * pilasters between them. */
  void buildWall(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const std::vector<double>& gates,
                 const std::vector<double>& doors);
  void addPilasters(const Spot& corner, double length);
  void buildWalls();
  /** Light walls with a lid, lower than the hall; its doors open into it. */
  void buildStoreRoom();
  /** A leaf that is shut when the map is made, and open later. */
  void shutLeaf(const Eigen::Vector2d& hinge, double closed, int sense);
  /** Columns on a grid, where nothing else stands; round ones in one row, square ones in the other. */
  void buildColumns();
  void buildBeams();

  // ---- Racks, and loose things (hall_furniture.cpp) ----
  void buildRack(double y, double yaw, Random& random);
  /** A low rail that guards the end of a row. */
  void addGuard(double x, double y, double width);
  void buildRacks();
  Eigen::AlignedBox2d openArea() const;
  /** Pallets in rows, as a fork lift puts them down; some places are empty. */
  void addPalletBlock(const Eigen::Vector2d& corner, int columns, int lines);
  void furnishOpenArea();
  /** The west end and the sides of the aisles, where people leave things. */
  void furnishAisles();
  void furnishStoreRoom();
  /** Notice boards, switch boxes, fire extinguishers and heaters on the walls. */
  void addFixtures();
  void addPeople();

  Eigen::AlignedBox2d hall_, store_;  // store_: between the lines of its walls
  double ceiling_ = 0;
  RackRow rack_;
  double racks_west_ = 0, racks_east_ = 0;             // x of their ends
  double aisle_1_ = 0, aisle_2_ = 0, aisle_3_ = 0;     // y of their middles
  std::vector<double> rows_;                           // y of the middles of the double rows
  double store_west_door_ = 0, store_north_door_ = 0;  // y and x
};

}  // namespace facetloc
