// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "floor_plan.h"
#include "furniture.h"
#include "scene_builder.h"

#include <facetloc/features/pose.h>

#include <cstdint>
#include <vector>

namespace facetloc {

/** \brief A flat: living room and kitchen in the west, a hallway from there to the entrance in the east;
 * south of it two bedrooms, equal on purpose, north of it a study between the kitchen and the bath. The
 * study, which has doors to the hallway and to the kitchen, is shut when the map is made. Half of the flats
 * are mirrored.
 *
 *     +---------+--------+------+
 *     | kitchen | study  | bath |
 *     |         +--------+------+
 *     +--   --+   hallway       |
 *     | living  +-------+-------+
 *     | room    | bed A | bed B |
 *     +---------+-------+-------+
 */
class HomeFloor : FurnishedFloor {
public:
  explicit HomeFloor(std::uint64_t seed) : FurnishedFloor(seed, kFurniture) {}

  SimulatedPlace build();

private:
  enum Purpose : std::uint64_t { kSizes, kWays, kFurniture };

  // Lengths in metres.
  static constexpr double kCeiling = 2.5;
  static constexpr double kWall = 0.12;  // thickness of the inner walls
  static constexpr double kHallwayWidth = 2.0;

  // ---- Sizes and ways (home_floor.cpp) ----
  void drawSizes();
  /** The robot goes through doors near their middle; elsewhere the two ways are apart. */
  void drawRoutes();

  // ---- Walls, windows and doors (home_walls.cpp) ----
  /** A window's bar and its curtains. */
  void dressWindow(const Spot& inside, const Opening& opening);
  Opening drawWindow(double at);
  /** The wall around the flat. Its line runs in its middle; windows are given by their place inside. */
  void buildOuterWalls();
  void buildInnerWalls();
  /** A leaf that stands open into a room: closed it would lie along a direction, opening turns it to one
   * side. */
  void openLeaf(const Eigen::Vector2d& hinge, double closed, int sense, double most);
  /** A leaf that is shut when the map is made. */
  void shutLeaf(const Eigen::Vector2d& hinge, double closed, int sense);
  void takeLeaf(const Eigen::Vector2d& hinge, double closed, int sense);
  void buildDoors();
  void addFrames();
  /** A chimney or a shaft for pipes in a corner of a room. */
  void addShaft(const Eigen::Vector2d& corner, const Eigen::Vector2d& inward);

  // ---- Furniture (home_furniture.cpp) ----
  void addPictures(const Eigen::AlignedBox2d& room, int number);
  /** Chairs at two sides of a table or in front of a desk; they look at it. */
  void addChairs(const Kind& kind, const Spot& table, const Eigen::AlignedBox2d& room, int number,
                 bool both_sides);
  void addDiningTable(const Eigen::AlignedBox2d& room);
  void addSmallThings(const Eigen::AlignedBox2d& room, int number);
  void furnishLivingRoom();
  void furnishKitchen();
  /** Both bedrooms have the same pieces, each placed by hand. */
  void furnishBedrooms();
  void furnishBath();
  void furnishHallway();
  void furnishStudy();
  /** Radiators below windows where nothing else stands. */
  void addRadiators();
  void addPeople();

  double width_ = 0, depth_ = 0;             // inside of the outer walls
  double west_ = 0;                          // x of the wall between the west rooms and the others
  double south_ = 0, north_ = 0;             // y of the hallway's walls
  double kitchen_ = 0;                       // y of the wall between the living room and the kitchen
  double between_bedrooms_ = 0, bath_ = 0;   // x of the walls there
  double door_a_ = 0, door_b_ = 0;           // x of the bedrooms' doors; the bath's is opposite the second
  double study_door_ = 0, pantry_door_ = 0;  // x of the one to the hallway, y of the one to the kitchen
  double kitchen_opening_ = 0;               // x
  std::vector<Spot> windows_;                // on the inner face, at the floor
  Eigen::AlignedBox2d living_room_, kitchen_room_, hallway_, bedroom_a_, bedroom_b_, study_, bath_room_;
};

}  // namespace facetloc
