// SPDX-License-Identifier: BSD-3-Clause
#include "scene_builder.h"

#include <facetloc/simulation/simulated_drive.h>
#include <facetloc/simulation/simulated_place.h>

#include <cmath>
#include <stdexcept>
#include <utility>

namespace facetloc {
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

const std::vector<std::string>& simulatedPlaceNames() {
  static const std::vector<std::string> names = {"office", "home",  "hall",    "corridor", "hotel",
                                                 "boards", "doors", "passage", "box"};
  return names;
}

SimulatedPlace simulatedPlace(const std::string& name, std::uint64_t seed) {
  if (name == "office") return officeFloor(seed);
  if (name == "home") return homeFloor(seed);
  if (name == "hall") return hallFloor(seed);
  if (name == "corridor") return bareCorridor(seed);
  if (name == "hotel") return equalRooms(seed);
  if (name == "boards") return bareFloor(seed);
  if (name == "doors") return equalDoors(seed, 16);
  if (name == "passage") return equalDoors(seed, 33);
  if (name == "box") return symmetricBox(seed);
  throw std::invalid_argument("there is no simulated place named '" + name + "'");
}

SimulatedWorld furnishedRoom(std::uint64_t seed) {
  constexpr int kBoxes = 16;
  return randomRoom(seed, kBoxes);
}

Intrinsics centredKinect(int width) {
  const Intrinsics kinect = kinectIntrinsics();
  const double scale = static_cast<double>(width) / kinect.width;
  const int height = static_cast<int>(std::lround(kinect.height * scale));
  const double f = kinect.fx * scale;
  return {width, height, f, f, (width - 1) / 2.0, (height - 1) / 2.0};
}

SimulatedRun simulatedRun(const std::string& place, std::uint64_t seed, std::uint64_t run, std::size_t frames,
                          const DriveParams& params, const std::optional<PaceParams>& pace,
                          std::optional<RouteEnd> end) {
  const std::uint64_t run_seed = runSeed(seed, run);
  if (place == kRoomName) {
    SimulatedWorld room = furnishedRoom(seed);
    std::vector<Eigen::Isometry3d> poses = simulateDrive(room, frames, params, run_seed, {}, pace);
    return {std::move(room), std::move(poses)};
  }
  SimulatedPlace made = simulatedPlace(place, seed);
  const bool is_later = run == kLaterRun;
  const RouteEnd usual = made.one_way ? RouteEnd::stop : RouteEnd::go_round;
  std::vector<Eigen::Isometry3d> poses = simulateDrive(is_later ? made.query_route : made.mapping_route,
                                                       frames, params, run_seed, pace, end.value_or(usual));
  return {std::move(is_later ? made.later : made.mapped), std::move(poses)};
}

}  // namespace facetloc
