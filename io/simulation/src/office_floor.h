// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scene_builder.h"

#include <facetloc/features/pose.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace facetloc {

/** \brief A storey of an office building: a loop of corridors around a core, with rooms on the outside.
 * Corridor walls carry doors in recesses at regular distances, so that one stretch looks like the next.
 * Lengths in metres. */
class OfficeFloor {
public:
  explicit OfficeFloor(std::uint64_t seed);

  SimulatedPlace build();

private:
  static constexpr double kQuarter = 90 * kDegree;
  static constexpr double kCeiling = 2.7;
  static constexpr double kWall = 0.14;    // thickness
  static constexpr double kRecess = 0.22;  // depth of doors behind the face of the corridor's wall
  static constexpr int kRooms = 4;
  static constexpr double kLane = 0.75;  // half width of the free space along the middle of a corridor

  /** One straight side of the loop: its wall seen from the corridor, from its start to its end, inside of the
   * corridor to the left. */
  struct Side {
    Eigen::Vector2d from, to;
    bool outer = false;

    double length() const { return (to - from).norm(); }
    Eigen::Vector2d along() const { return (to - from).normalized(); }
    Eigen::Vector2d inward() const { return {-along().y(), along().x()}; }
    Eigen::Vector2d at(double s) const { return from + s * along(); }
    double yaw() const { return std::atan2(inward().y(), inward().x()); }
  };

  /** A room behind a long outer side, two on each: where its door is along the side, and its reach. */
  struct Room {
    double door = 0;
    double left = 2, right = 2;  // distances from the door, as seen from the corridor
    double depth = 4;
    std::vector<Opening> windows;  // openings in its outer wall, from the left
  };

  // ---- Sizes, ways, and where things are (office_floor.cpp) ----
  void drawSizes();
  Eigen::Vector2d outer() const { return half_ + Eigen::Vector2d::Constant(corridor_ / 2); }
  Eigen::Vector2d inner() const { return half_ - Eigen::Vector2d::Constant(corridor_ / 2); }

  /** The walls of the corridor: four outside, which the corridor is to the left of, and four of the core. */
  std::vector<Side> sides() const;

  /** The long outer side that a room lies behind: 0 and 1 behind the first, 2 and 3 behind the third. */
  static int sideOf(int room) { return room < 2 ? 0 : 2; }
  bool isRoomDoor(const Side& side, double s, double margin) const;

  /** A room in a frame of its own: x out of the corridor through its door, y to the left of that. */
  Spot roomFrame(int room) const;
  Eigen::Vector2d cornerOf(int k, double offset) const;
  /** Points in front of a room's door, at this offset from the middle of the corridor, and inside. */
  Eigen::Vector2d beforeDoor(int room, double offset) const;
  Eigen::Vector2d insideRoom(int room, double depth, double aside = 0) const;
  /** Into a room, a look around, and out again. */
  void visit(Route& route, int room, double offset, double depth, double aside, double look_deg) const;
  void buildRoutes();
  /** Drives from the first corner around to the left, back to it, with visits to rooms. */
  void drive(Route& route, double offset, const std::vector<int>& rooms, const Eigen::Vector2d& inside,
             double look_deg) const;

  // ---- Walls, doors and ceiling (office_walls.cpp) ----
  void buildShell();
  /** A wall with doors in recesses at regular distances; on the short outer sides there are windows. */
  void buildWall(const Side& side);
  /** A door at the back of its recess: closed, or ajar into the room behind. */
  void hangDoor(const Side& side, const Opening& opening);
  /** The far wall of the space that shows through a door ajar; it does not reach into other corridors. */
  void hideBehind(const Side& side, double at);
  /** The rooms outside the long sides: one is mapped, one is entered only later, two are seen in passing. */
  void buildRooms();
  void buildRoom(int k);
  /** Boards around an opening, on the side of the room. */
  void frameDoor(const Spot& door);
  /** A ceiling with beams across the corridors. */
  void buildCeiling();

  // ---- Furniture (office_furniture.cpp) ----
  /** Pillars, cupboards, boards, bins and plants between the doors; they leave the lane free. */
  void furnishWall(const Side& side);
  void pillar(const Spot& spot, double depth);
  void noticeBoard(const Spot& spot);
  /** A thing that may have moved along its wall, or have gone, when the robot comes back. */
  template <class Add>
  void movable(const Spot& spot, double shift, const Add& add);
  /** A piece of furniture, of the same size wherever it stands. */
  template <class Add>
  void furniture(const Spot& spot, const Add& add);
  /** Desks at the side walls, radiators below the windows, cupboards, boards, chairs, the one or the other
   * way around; the way in stays free. */
  void furnishRoom(const Spot& door, const Room& room);

  std::uint64_t seed_;
  std::uint64_t pieces_ = 0;
  SimulatedPlace place_;
  Random random_;
  SceneBuilder builder_;
  Eigen::Vector2d half_;
  double corridor_ = 2;
  double spacing_ = 3;
  std::array<Room, kRooms> rooms_;
  int mapped_ = 0, unmapped_ = 0;  // the rooms that are entered
};

}  // namespace facetloc
