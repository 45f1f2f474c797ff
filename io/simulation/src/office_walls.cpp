// SPDX-License-Identifier: BSD-3-Clause
#include "office_floor.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace facetloc {
namespace {

using Eigen::Vector2d;

// Lengths in metres.
constexpr double kDoorWidth = 0.92, kDoorHeight = 2.05;
constexpr double kRoomReach = 6;  // reach of floor and ceiling beyond the corridors

}  // namespace

void OfficeFloor::buildShell() {
  const Vector2d reach = outer() + Vector2d::Constant(kRoomReach);
  builder_.level({-reach, reach}, 0);
  const Vector2d shell[] = {
      {-reach.x(), -reach.y()}, {reach.x(), -reach.y()}, reach, {-reach.x(), reach.y()}};
  for (int k = 0; k < 4; ++k) builder_.wall(shell[k], shell[(k + 1) % 4], kWall, kCeiling);
  for (const Side& side : sides()) buildWall(side);
}

void OfficeFloor::buildWall(const Side& side) {
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

void OfficeFloor::hangDoor(const Side& side, const Opening& opening) {
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

void OfficeFloor::hideBehind(const Side& side, double at) {
  constexpr double kDepth = 1.6, kMargin = 0.5;
  const double half = std::min({1.5, at - kMargin, side.length() - at - kMargin});
  const Vector2d middle = side.at(at) - side.inward() * (kRecess + kDepth);
  const Vector2d along = half * side.along();
  builder_.rectangle({middle.x(), middle.y(), kCeiling / 2}, {along.x(), along.y(), 0}, {0, 0, kCeiling / 2});
}

void OfficeFloor::buildRooms() {
  for (int room = 0; room < kRooms; ++room) buildRoom(room);
}

void OfficeFloor::buildRoom(int k) {
  const Room& room = rooms_[k];
  const Spot door = roomFrame(k);
  const auto corner = [&](double x, double y) { return door.relative(x, y).place; };
  // Side walls, and an outer wall with windows. The corridor's wall is the fourth.
  builder_.wall(corner(0, room.left), corner(room.depth, room.left), kWall, kCeiling);
  builder_.wall(corner(0, -room.right), corner(room.depth, -room.right), kWall, kCeiling);
  builder_.wall(corner(room.depth, room.left), corner(room.depth, -room.right), kWall, kCeiling,
                room.windows);
  frameDoor(door);
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

void OfficeFloor::frameDoor(const Spot& door) {
  constexpr double kBoard = 0.08, kThickness = 0.02;
  for (const int side : {-1, 1})
    builder_.box(door.relative(kThickness / 2, side * (0.5 + kBoard / 2)), {kThickness, kBoard, kDoorHeight});
  builder_.box(door.relative(kThickness / 2, 0, 0, kDoorHeight), {kThickness, 1 + 2 * kBoard, kBoard});
}

void OfficeFloor::buildCeiling() {
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

}  // namespace facetloc
