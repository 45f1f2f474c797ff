// SPDX-License-Identifier: BSD-3-Clause
#include "furniture.h"
#include "scene_builder.h"

#include <facetloc/features/pose.h>

#include <Eigen/Geometry>

#include <vector>

namespace facetloc {
namespace {

using Eigen::Vector2d;

constexpr double kPi = 180 * kDegree;
constexpr int kRoomsOfASide = 6;
// Sizes [m].
constexpr double kRoomWidth = 4.4, kRoomDepth = 5, kHalfCorridor = 1.1, kHeight = 2.5, kWall = 0.12;
constexpr double kDoor = 0.95;
constexpr double kIntoRoom = 2.2;   // that the robot drives past the door
constexpr double kOffMiddle = 0.1;  // offset of the later run
constexpr double kLook = 120;       // that the robot turns in a room [deg]

double middleOf(int room) { return (room + 0.5) * kRoomWidth; }

/** The middle of a doorway, x into the room. */
Spot doorwayOf(int room, double side) { return {{middleOf(room), side * kHalfCorridor}, side * kPi / 2}; }

/** All that stands in a room, the same in all of them. */
void furnish(SceneBuilder& builder, const Spot& doorway, Random random) {
  const double back = kRoomDepth, side = kRoomWidth / 2;
  kind::kBed.add(builder, doorway.relative(back - 1.2, -side + 1.1, kPi / 2), random, When::always);
  kind::kWardrobe.add(builder, doorway.relative(0.9, side - 0.45, -kPi / 2), random, When::always);
  kind::kDesk.add(builder, doorway.relative(back - 0.5, side - 1.1, kPi), random, When::always);
  kind::kArmchair.add(builder, doorway.relative(2.6, side - 0.6, -kPi / 2), random, When::always);
  kind::kSideboard.add(builder, doorway.relative(1.2, -side + 0.4, kPi / 2), random, When::always);
}

/** Places things in the corridor beside each door: they distinguish the doors. */
void placeBesideDoor(SceneBuilder& builder, const Spot& doorway, Random& random) {
  const double left = random.uniform() < 0.5 ? 1 : -1;
  const Spot spot = doorway.relative(-0.25, left * random.uniform(0.9, 1.7), kPi);
  const Eigen::Vector3d size(0.3, random.uniform(0.3, 0.9), random.uniform(0.4, 2.0));
  builder.box(spot, size);
  const Vector2d hinge = doorway.relative(-kWall / 2, left * kDoor / 2).place;
  builder.doorLeaf(hinge, doorway.yaw + kPi + left * random.uniform(0.3, 1.3), kDoor, 2.0);
}

/** Along the corridor; at each pair of doors into one room, straight across into the other, and out. */
Route wayThrough(double off_middle) {
  Route route;
  for (int room = 0; room < kRoomsOfASide; ++room) {
    const double x = middleOf(room) + off_middle;
    route.push_back({{x, off_middle}, 0});
    for (const double side : {1, -1}) route.push_back({{x, side * (kHalfCorridor + kIntoRoom)}, kLook});
    route.push_back({{x, off_middle}, 0});
  }
  return route;
}

}  // namespace

SimulatedPlace equalRooms(std::uint64_t seed) {
  Random random(seed);
  const Random of_rooms(derivedSeed(seed, 1));
  SimulatedPlace place;
  SceneBuilder builder(place);
  const double length = kRoomsOfASide * kRoomWidth, half_depth = kHalfCorridor + kRoomDepth;
  const Eigen::AlignedBox2d area(Vector2d(0, -half_depth), Vector2d(length, half_depth));
  builder.level(area, 0);
  builder.level(area, kHeight);
  std::vector<Opening> doors;
  for (int room = 0; room < kRoomsOfASide; ++room) doors.push_back({middleOf(room), kDoor});
  for (const double side : {1, -1}) {
    builder.wall({0, side * kHalfCorridor}, {length, side * kHalfCorridor}, kWall, kHeight, doors);
    builder.wall({0, side * half_depth}, {length, side * half_depth}, kWall, kHeight);
    for (int room = 0; room <= kRoomsOfASide; ++room)
      builder.wall({room * kRoomWidth, side * kHalfCorridor}, {room * kRoomWidth, side * half_depth}, kWall,
                   kHeight);
    for (int room = 0; room < kRoomsOfASide; ++room) {
      furnish(builder, doorwayOf(room, side), of_rooms);
      placeBesideDoor(builder, doorwayOf(room, side), random);
    }
  }
  for (const double x : {0.0, length}) builder.wall({x, -kHalfCorridor}, {x, kHalfCorridor}, kWall, kHeight);
  place.mapping_route = wayThrough(0);
  place.query_route = wayThrough(random.uniform(-kOffMiddle, kOffMiddle));
  return place;
}

}  // namespace facetloc
