// SPDX-License-Identifier: BSD-3-Clause
#include "furniture.h"
#include "scene_builder.h"

#include <facetloc/features/pose.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace facetloc {
namespace {

using Eigen::Vector2d;

// Distance of the robot's line from things beside the lane [m].
constexpr double kClearance = 0.42;

// Lengths in metres.
constexpr double kDoorWidth = 0.92, kDoorHeight = 2.05;
constexpr double kRoomReach = 6;     // reach of floor and ceiling beyond the corridors
constexpr double kShareMoved = 0.2;  // share of the loose things

/** \brief A storey of an office building: a loop of corridors around a core, with rooms on the outside.
 * Corridor walls carry doors in recesses at regular distances, so that one stretch looks like the next.
 * Lengths in metres. */
class OfficeFloor {
public:
  explicit OfficeFloor(std::uint64_t seed) : seed_(seed), random_(seed), builder_(place_) {}

  SimulatedPlace build() {
    drawSizes();
    buildShell();
    for (const Side& side : sides()) furnishWall(side);
    for (int room = 0; room < kRooms; ++room) buildRoom(room);
    buildCeiling();
    buildRoutes();
    return std::move(place_);
  }

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

  // ---- Sizes, ways, and where things are ----
  void drawSizes() {
    half_.x() = random_.uniform(6.2, 7.5);  // half length of the loop, to the middle of the corridor
    half_.y() = random_.uniform(3.8, 4.6);
    corridor_ = random_.uniform(2.0, 2.4);
    spacing_ = random_.uniform(2.6, 3.2);
    for (int k = 0; k < kRooms; ++k) {
      Room& room = rooms_[k];
      room.door = outer().x() * 2 * ((k % 2 ? 0.68 : 0.3) + random_.uniform(-0.02, 0.02));
      room.left = random_.uniform(1.95, 2.4);
      room.right = random_.uniform(1.7, 2.2);
      room.depth = random_.uniform(3.8, 4.8);
      const int windows = 1 + static_cast<int>(2 * random_.uniform());
      const double bay = (room.left + room.right) / windows;
      for (int i = 0; i < windows; ++i) {
        const double width = random_.uniform(0.9, std::min(2.0, bay - 0.5));
        const double middle = (i + 0.5) * bay + random_.uniform(-0.15, 0.15);
        room.windows.push_back({middle, width, random_.uniform(0.8, 1.0), 2.2, true});
      }
    }
    unmapped_ = random_.uniform() < 0.5 ? 0 : 1;
    mapped_ = random_.uniform() < 0.5 ? 2 : 3;
  }

  Eigen::Vector2d outer() const { return half_ + Eigen::Vector2d::Constant(corridor_ / 2); }
  Eigen::Vector2d inner() const { return half_ - Eigen::Vector2d::Constant(corridor_ / 2); }

  /** The walls of the corridor: four outside, which the corridor is to the left of, and four of the core. */
  std::vector<Side> sides() const {
    const Vector2d o = outer(), i = inner();
    const Vector2d po[] = {{-o.x(), -o.y()}, {o.x(), -o.y()}, {o.x(), o.y()}, {-o.x(), o.y()}};
    const Vector2d pi[] = {{-i.x(), -i.y()}, {-i.x(), i.y()}, {i.x(), i.y()}, {i.x(), -i.y()}};
    std::vector<Side> all;
    for (int k = 0; k < 4; ++k) all.push_back({po[k], po[(k + 1) % 4], true});
    for (int k = 0; k < 4; ++k) all.push_back({pi[k], pi[(k + 1) % 4], false});
    return all;
  }

  /** The long outer side that a room lies behind: 0 and 1 behind the first, 2 and 3 behind the third. */
  static int sideOf(int room) { return room < 2 ? 0 : 2; }

  bool isRoomDoor(const Side& side, double s, double margin) const {
    for (int k = 0; k < kRooms; ++k)
      if ((side.from - sides()[sideOf(k)].from).norm() < 1e-9 && std::abs(s - rooms_[k].door) < margin)
        return true;
    return false;
  }

  /** A room in a frame of its own: x out of the corridor through its door, y to the left of that. */
  Spot roomFrame(int room) const {
    const Side side = sides()[sideOf(room)];
    return {side.at(rooms_[room].door) - side.inward() * kRecess, side.yaw() + 2 * kQuarter};
  }

  Vector2d cornerOf(int k, double offset) const {
    const Vector2d h = half_ + Vector2d::Constant(offset);
    const double sx[] = {-1, 1, 1, -1}, sy[] = {-1, -1, 1, 1};
    return {sx[k % 4] * h.x(), sy[k % 4] * h.y()};
  }

  /** Into a room, a look around, and out again, from this offset to the middle of the corridor. */
  void visit(Route& route, int room, double offset, const Vector2d& inside, double look_deg) const {
    const Spot frame = roomFrame(room);
    const Waypoint before_door{frame.relative(-(kRecess + corridor_ / 2 - offset), 0).place};
    route.push_back(before_door);
    route.push_back({frame.relative(inside.x(), inside.y()).place, look_deg});
    route.push_back(before_door);
  }

  void buildRoutes() {
    // Once around to the left, with a room on the way; then a short side in the other direction.
    const double map_offset = random_.uniform(-0.08, 0.08);
    drive(place_.mapping_route, map_offset, {mapped_}, {1.7, 0}, 60);
    place_.mapping_route.push_back({cornerOf(0, map_offset)});
    place_.mapping_route.push_back({cornerOf(3, map_offset)});

    // Later on another line: the short side there and back, then around to the left.
    const double most = kLane - kClearance;
    const double side = random_.uniform() < 0.5 ? -1 : 1;
    const double offset = side * random_.uniform(0.5, 1.0) * most;
    place_.query_route.push_back({cornerOf(0, -offset)});
    place_.query_route.push_back({cornerOf(3, -offset)});
    drive(place_.query_route, offset, {mapped_, unmapped_}, {1.8, 0.15}, 80);
  }

  /** Drives from the first corner around to the left, back to it, with visits to rooms. */
  void drive(Route& route, double offset, const std::vector<int>& rooms, const Vector2d& inside,
             double look_deg) const {
    for (int corner = 0; corner < 4; ++corner) {
      route.push_back({cornerOf(corner, offset)});
      for (int room = 0; room < kRooms; ++room)
        if (sideOf(room) == corner && std::count(rooms.begin(), rooms.end(), room) > 0)
          visit(route, room, offset, inside, look_deg);
    }
  }

  // ---- Walls, doors and ceiling ----
  void buildShell() {
    const Vector2d reach = outer() + Vector2d::Constant(kRoomReach);
    builder_.level({-reach, reach}, 0);
    const Vector2d shell[] = {
        {-reach.x(), -reach.y()}, {reach.x(), -reach.y()}, reach, {-reach.x(), reach.y()}};
    for (int k = 0; k < 4; ++k) builder_.wall(shell[k], shell[(k + 1) % 4], kWall, kCeiling);
    for (const Side& side : sides()) buildWall(side);
  }

  /** A wall with doors in recesses at regular distances; on the short outer sides there are windows. */
  void buildWall(const Side& side) {
    const bool windows = side.outer && std::abs(side.along().y()) > 0.5;
    std::vector<Opening> openings;
    for (double s = spacing_ / 2 + 0.3; s < side.length() - 0.8; s += spacing_) {
      if (isRoomDoor(side, s, kDoorWidth + 0.5)) continue;
      if (windows)
        openings.push_back({s, 1.3, 0.9, 2.2, true});
      else if (random_.uniform() < 0.85)
        openings.push_back({s, kDoorWidth + 0.06, 0, kDoorHeight + 0.03, false});
    }
    const std::size_t regular = openings.size();
    for (int k = 0; k < kRooms; ++k)
      if (isRoomDoor(side, rooms_[k].door, 1e-9)) openings.push_back({rooms_[k].door, 1.0, 0, kDoorHeight});
    // The wall is as thick as the recesses are deep; its face is where the corridor ends.
    const Vector2d shift = -side.inward() * kRecess / 2;
    builder_.wall(side.from + shift, side.to + shift, kRecess, kCeiling, openings);
    for (std::size_t k = 0; k < regular && !windows; ++k) hangDoor(side, openings[k]);
  }

  /** A door at the back of its recess: closed, or ajar into the room behind. */
  void hangDoor(const Side& side, const Opening& opening) {
    const Vector2d hinge = side.at(opening.at - kDoorWidth / 2) - side.inward() * kRecess;
    const double closed = std::atan2(side.along().y(), side.along().x());
    const bool can_open = !isRoomDoor(side, opening.at, 2.2 + kDoorWidth);
    const bool ajar = can_open && random_.uniform() < 0.2;
    const double angle = ajar ? random_.uniform(10, 60) * kDegree : 0;
    const bool moved = can_open && random_.uniform() < 0.15;
    const double later = moved ? random_.uniform(0, 60) * kDegree : angle;
    if (later == angle) {
      builder_.doorLeaf(hinge, closed - angle, kDoorWidth, kDoorHeight);
    } else {
      builder_.doorLeaf(hinge, closed - angle, kDoorWidth, kDoorHeight, When::mapped);
      builder_.doorLeaf(hinge, closed - later, kDoorWidth, kDoorHeight, When::later);
    }
    if (ajar || moved) hideBehind(side, opening.at);
  }

  /** The far wall of the space that shows through a door ajar; it does not reach into other corridors. */
  void hideBehind(const Side& side, double at) {
    constexpr double kDepth = 1.6, kMargin = 0.5;
    const double half = std::min({1.5, at - kMargin, side.length() - at - kMargin});
    const Vector2d middle = side.at(at) - side.inward() * (kRecess + kDepth);
    const Vector2d along = half * side.along();
    builder_.rectangle({middle.x(), middle.y(), kCeiling / 2}, {along.x(), along.y(), 0},
                       {0, 0, kCeiling / 2});
  }

  /** A room outside a long side: one is mapped, one is entered only later, two are seen in passing. */
  void buildRoom(int k) {
    const Room& room = rooms_[k];
    const Spot door = roomFrame(k);
    const auto corner = [&](double x, double y) { return door.relative(x, y).place; };
    // Side walls, and an outer wall with windows. The corridor's wall is the fourth.
    builder_.wall(corner(0, room.left), corner(room.depth, room.left), kWall, kCeiling);
    builder_.wall(corner(0, -room.right), corner(room.depth, -room.right), kWall, kCeiling);
    builder_.wall(corner(room.depth, room.left), corner(room.depth, -room.right), kWall, kCeiling,
                  room.windows);
    addDoorFrame(builder_, door, 1, kDoorHeight);
    // The door stands open at a wall; the one of the unmapped room was closed when the map was made.
    const double open = random_.uniform(110, 165) * kDegree;
    const double closed = door.yaw - kQuarter;
    const auto leaf = [&](double direction, When when) {
      builder_.doorLeaf(corner(0.03, 0.5), direction, 0.99, kDoorHeight, when);
    };
    if (k == unmapped_) leaf(closed, When::mapped);
    leaf(closed + open, k == unmapped_ ? When::later : When::always);
    furnishRoom(door, room);
    if (k == unmapped_)
      place_.unmapped_rooms.emplace_back(corner(0, room.left).cwiseMin(corner(room.depth, -room.right)),
                                         corner(0, room.left).cwiseMax(corner(room.depth, -room.right)));
  }

  /** A ceiling with beams across the corridors. */
  void buildCeiling() {
    const Vector2d reach = outer() + Vector2d::Constant(kRoomReach);
    builder_.level({-reach, reach}, kCeiling);
    const double drop = random_.uniform(0.15, 0.3), width = random_.uniform(0.2, 0.35);
    for (const Side& side : sides()) {
      if (!side.outer) continue;
      for (double s = corridor_ + random_.uniform(0.5, 1.5); s < side.length() - corridor_; s += 2 * spacing_)
        builder_.box({side.at(s) + side.inward() * corridor_ / 2, side.yaw(), kCeiling - drop},
                     {corridor_, width, drop});
    }
  }

  // ---- Furniture ----
  /** Pillars, cupboards, boards, bins and plants between the doors; they leave the lane free. */
  void furnishWall(const Side& side) {
    const double free = corridor_ / 2 - kLane;  // depth that things may have
    for (double s = 0.3 + spacing_; s < side.length() - 0.6; s += spacing_) {
      if (isRoomDoor(side, s, 1.3)) continue;
      const Spot spot{side.at(s), side.yaw()};
      const double choice = random_.uniform();
      if (choice < 0.25) {
        pillar(spot, std::min(free, random_.uniform(0.12, 0.3)));
      } else if (choice < 0.45) {
        const double depth = std::min(free, 0.38);
        const double width = random_.uniform(0.7, 1.1), height = random_.uniform(0.8, 2.0);
        const bool dark = random_.uniform() < 0.2;
        movable(spot, random_.uniform(-0.3, 0.3), [&](const Spot& at, When when) {
          builder_.box(at.relative(depth / 2 + 0.01, 0), {depth, width, height}, when,
                       dark ? Material::dark : Material::matt);
        });
      } else if (choice < 0.65) {
        noticeBoard(spot);
      } else if (choice < 0.8) {
        furniture(spot.relative(0.24, 0), kind::kBin);
      } else if (choice < 0.88 && free > 0.4) {
        furniture(spot.relative(0.26, 0), kind::kPlant);
      }
    }
  }

  void pillar(const Spot& spot, double depth) {
    builder_.pillar(spot.relative(depth / 2, 0), {depth, random_.uniform(0.3, 0.5), kCeiling});
  }

  void noticeBoard(const Spot& spot) {
    const double width = random_.uniform(0.6, 1.4), height = random_.uniform(0.6, 1.0);
    builder_.box(spot.relative(0.02, 0, 0, random_.uniform(1.0, 1.3)), {0.04, width, height});
  }

  /** A thing that may have moved along its wall, or have gone, when the robot comes back. */
  template <class Add>
  void movable(const Spot& spot, double shift, const Add& add) {
    const double fate = random_.uniform();
    if (fate > kShareMoved) return add(spot, When::always);
    add(spot, When::mapped);
    if (fate > kShareMoved / 3) add(spot.relative(0, shift), When::later);
  }

  /** A piece of furniture, of the same size wherever it stands. */
  void furniture(const Spot& spot, const Kind& kind) {
    constexpr std::uint64_t kPurpose = 1;
    const Random sizes(derivedSeed(seed_, kPurpose, ++pieces_));
    movable(spot, random_.uniform(-0.3, 0.3), [&](const Spot& at, When when) {
      Random same = sizes;
      kind.add(builder_, at, same, when);
    });
  }

  /** Desks at the side walls, radiators below the windows, cupboards, boards, chairs, the one or the other
   * way around; the way in stays free. */
  void furnishRoom(const Spot& door, const Room& room) {
    const double turn = random_.uniform() < 0.5 ? 1 : -1;  // which side is called the left
    const double left = (turn > 0 ? room.left : room.right) - kWall / 2;
    const double right = (turn > 0 ? room.right : room.left) - kWall / 2;
    const double depth = room.depth - kWall / 2;
    const auto at = [&](double x, double y, double yaw, double z = 0) {
      return door.relative(x, turn * y, turn * yaw, z);
    };
    const auto likely = [&](double probability) { return random_.uniform() < probability; };

    const double desk = depth - random_.uniform(0.9, 1.5);
    furniture(at(desk, left - 0.4, -kQuarter), kind::kDesk);
    furniture(at(desk + random_.uniform(-0.2, 0.2), left - 1.0, kQuarter), kind::kChair);
    if (likely(0.6)) furniture(at(depth - random_.uniform(0.9, 1.4), -(right - 0.4), kQuarter), kind::kDesk);
    if (likely(0.6)) furniture(at(random_.uniform(0.9, 1.3), -(right - 0.2), kQuarter), kind::kBookcase);
    if (likely(0.6)) furniture(at(random_.uniform(1.2, 1.6), left - 0.25, -kQuarter), kind::kCupboard);
    if (likely(0.5)) furniture(at(depth - 0.4, random_.uniform(-0.4, 0.4), 2 * kQuarter), kind::kPlant);
    if (likely(0.35)) furniture(at(depth - 0.7, -(right - 1.0), random_.uniform(-3, 3)), kind::kPerson);
    for (const Opening& window : room.windows)
      builder_.box(door.relative(depth - 0.06, room.left - window.at, 0, 0.15),
                   {0.1, 0.75 * window.width, 0.6});

    // Boards on the walls at the sides, and beside the door.
    const auto board = [&](const Spot& spot, double width) {
      builder_.box(spot, {0.04, width, random_.uniform(0.5, 1.0)});
    };
    if (likely(0.8))
      board(at(random_.uniform(1.6, 2.6), left - 0.02, -kQuarter, 1.15), random_.uniform(0.6, 1.6));
    if (likely(0.7))
      board(at(random_.uniform(1.6, 2.8), -(right - 0.02), kQuarter, 1.2), random_.uniform(0.4, 1.4));
    if (likely(0.5)) board(at(0.02, -(0.75 + right) / 2, 0, random_.uniform(0.9, 1.3)), 0.6 * (right - 0.7));
  }

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

}  // namespace

SimulatedPlace officeFloor(std::uint64_t seed) { return OfficeFloor(seed).build(); }

}  // namespace facetloc
