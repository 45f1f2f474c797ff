// SPDX-License-Identifier: BSD-3-Clause
#include "scene_builder.h"

#include <facetloc/simulation/simulated_drive.h>
#include <facetloc/simulation/simulated_place.h>

#include <cmath>
#include <stdexcept>
#include <utility>

namespace facetloc {

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
