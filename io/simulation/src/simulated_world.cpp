// SPDX-License-Identifier: BSD-3-Clause
#include "scene_builder.h"

#include <facetloc/features/pose.h>
#include <facetloc/simulation/simulated_place.h>

#include <cmath>

namespace facetloc {

void addBox(SimulatedWorld& world, const Eigen::Isometry3d& T_w_box, const Eigen::Vector3d& half_size,
            std::uint16_t& next_id) {
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (const int side : {-1, 1}) {
      Rectangle face;
      face.centre = T_w_box * (side * half_size[axis] * Eigen::Vector3d::Unit(axis));
      face.axis_u = T_w_box.linear().col(u);
      face.axis_v = T_w_box.linear().col(v);
      face.half_u = half_size[u];
      face.half_v = half_size[v];
      face.plane_id = next_id++;
      world.rectangles.push_back(face);
    }
  }
}

namespace {

/** The sizes of a room and of the boxes in it [m]. */
constexpr double kMinRoom = 3, kMaxRoom = 7;
constexpr double kMinCeiling = 2.4, kMaxCeiling = 3.0;
constexpr double kMinBoxHeight = 0.3, kMaxBoxHeight = 2.0;
constexpr double kMinBoxSide = 0.3, kMaxBoxSide = 1.2;
constexpr double kMinCupboardDepth = 0.25, kMaxCupboardDepth = 0.6;
constexpr double kMaxCupboardHeight = 1.0;
constexpr double kFreeRadius = 0.8;  // the middle of the room stays free for a camera
constexpr double kShareOfCupboards = 0.35;
constexpr double kShareOfTurnedBoxes = 0.5;
constexpr double kShrink = 0.95;  // factor on a box that found no place, before the next try

/** A box on the floor, anywhere but in the free middle. */
void addFloorBox(SimulatedWorld& world, const Eigen::Vector3d& room, Random& random, std::uint16_t& next_id) {
  const double yaw = random.uniform() < kShareOfTurnedBoxes ? random.uniform(0, EIGEN_PI / 2) : 0.0;
  const double half_height = random.uniform(kMinBoxHeight, kMaxBoxHeight) / 2;
  double a = random.uniform(kMinBoxSide, kMaxBoxSide) / 2, b = random.uniform(kMinBoxSide, kMaxBoxSide) / 2;
  for (;; a *= kShrink, b *= kShrink) {
    const double c = std::abs(std::cos(yaw)), s = std::abs(std::sin(yaw));
    const double room_x = room.x() / 2 - (c * a + s * b), room_y = room.y() / 2 - (s * a + c * b);
    const double x = random.uniform(-room_x, room_x), y = random.uniform(-room_y, room_y);
    if (std::hypot(x, y) - std::hypot(a, b) < kFreeRadius) continue;
    return addBox(world, Spot{{x, y}, yaw, half_height}.pose(), {a, b, half_height}, next_id);
  }
}

/** A box on a wall, at any height. */
void addCupboard(SimulatedWorld& world, const Eigen::Vector3d& room, Random& random, std::uint16_t& next_id) {
  const int wall = static_cast<int>(4 * random.uniform());
  const double half_depth = random.uniform(kMinCupboardDepth, kMaxCupboardDepth) / 2;
  const double half_width = random.uniform(kMinBoxSide, kMaxBoxSide) / 2;
  const double half_height = random.uniform(kMinBoxHeight, kMaxCupboardHeight) / 2;
  const bool on_x = wall < 2;
  const double sign = wall % 2 ? 1.0 : -1.0;
  const double to_wall = sign * ((on_x ? room.x() : room.y()) / 2 - half_depth);
  const double margin = (on_x ? room.y() : room.x()) / 2 - half_width;
  const double along = random.uniform(-margin, margin);
  const double z = random.uniform(half_height, room.z() - half_height);
  const Eigen::Vector3d half_size = on_x ? Eigen::Vector3d(half_depth, half_width, half_height)
                                         : Eigen::Vector3d(half_width, half_depth, half_height);
  const Eigen::Vector2d place = on_x ? Eigen::Vector2d(to_wall, along) : Eigen::Vector2d(along, to_wall);
  addBox(world, Spot{place, 0, z}.pose(), half_size, next_id);
}

}  // namespace

SimulatedWorld randomRoom(std::uint64_t seed, int boxes) {
  Random random(seed);
  Eigen::Vector3d room;  // one draw per statement: the order of arguments is the compiler's choice
  room.x() = random.uniform(kMinRoom, kMaxRoom);
  room.y() = random.uniform(kMinRoom, kMaxRoom);
  room.z() = random.uniform(kMinCeiling, kMaxCeiling);
  SimulatedWorld world;
  std::uint16_t next_id = 1;
  addBox(world, Spot{{0, 0}, 0, room.z() / 2}.pose(), room / 2, next_id);  // walls, floor and ceiling
  for (int i = 0; i < boxes; ++i) {
    const bool on_wall = random.uniform() < kShareOfCupboards;
    (on_wall ? addCupboard : addFloorBox)(world, room, random, next_id);
  }
  return world;
}

}  // namespace facetloc
