// SPDX-License-Identifier: BSD-3-Clause
#include "office_floor.h"

#include <algorithm>
#include <utility>

namespace facetloc {
namespace {

using Eigen::Vector2d;

// Distance of the robot's line from things beside the lane [m].
constexpr double kClearance = 0.42;

}  // namespace

OfficeFloor::OfficeFloor(std::uint64_t seed) : seed_(seed), random_(seed), builder_(place_) {}

SimulatedPlace OfficeFloor::build() {
  drawSizes();
  buildShell();
  for (const Side& side : sides()) furnishWall(side);
  buildRooms();
  buildCeiling();
  buildRoutes();
  return std::move(place_);
}

void OfficeFloor::drawSizes() {
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

std::vector<OfficeFloor::Side> OfficeFloor::sides() const {
  const Vector2d o = outer(), i = inner();
  const Vector2d po[] = {{-o.x(), -o.y()}, {o.x(), -o.y()}, {o.x(), o.y()}, {-o.x(), o.y()}};
  const Vector2d pi[] = {{-i.x(), -i.y()}, {-i.x(), i.y()}, {i.x(), i.y()}, {i.x(), -i.y()}};
  std::vector<Side> all;
  for (int k = 0; k < 4; ++k) all.push_back({po[k], po[(k + 1) % 4], true});
  for (int k = 0; k < 4; ++k) all.push_back({pi[k], pi[(k + 1) % 4], false});
  return all;
}

bool OfficeFloor::isRoomDoor(const Side& side, double s, double margin) const {
  for (int k = 0; k < kRooms; ++k)
    if ((side.from - sides()[sideOf(k)].from).norm() < 1e-9 && std::abs(s - rooms_[k].door) < margin)
      return true;
  return false;
}

Spot OfficeFloor::roomFrame(int room) const {
  const Side side = sides()[sideOf(room)];
  return {side.at(rooms_[room].door) - side.inward() * kRecess, side.yaw() + 2 * kQuarter};
}

Vector2d OfficeFloor::cornerOf(int k, double offset) const {
  const Vector2d h = half_ + Vector2d::Constant(offset);
  const double sx[] = {-1, 1, 1, -1}, sy[] = {-1, -1, 1, 1};
  return {sx[k % 4] * h.x(), sy[k % 4] * h.y()};
}

Vector2d OfficeFloor::beforeDoor(int room, double offset) const {
  return roomFrame(room).relative(-(kRecess + corridor_ / 2 - offset), 0).place;
}

Vector2d OfficeFloor::insideRoom(int room, double depth, double aside) const {
  return roomFrame(room).relative(depth, aside).place;
}

void OfficeFloor::visit(Route& route, int room, double offset, double depth, double aside,
                        double look_deg) const {
  route.push_back({beforeDoor(room, offset)});
  route.push_back({insideRoom(room, depth, aside), look_deg});
  route.push_back({beforeDoor(room, offset)});
}

void OfficeFloor::buildRoutes() {
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

void OfficeFloor::drive(Route& route, double offset, const std::vector<int>& rooms, const Vector2d& inside,
                        double look_deg) const {
  for (int corner = 0; corner < 4; ++corner) {
    route.push_back({cornerOf(corner, offset)});
    for (int room = 0; room < kRooms; ++room)
      if (sideOf(room) == corner && std::count(rooms.begin(), rooms.end(), room) > 0)
        visit(route, room, offset, inside.x(), inside.y(), look_deg);
  }
}

SimulatedPlace officeFloor(std::uint64_t seed) { return OfficeFloor(seed).build(); }

}  // namespace facetloc
