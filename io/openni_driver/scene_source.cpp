// SPDX-License-Identifier: BSD-3-Clause
#include "scene_source.h"

#include "millimetres.h"

#include <facetloc/io/error.h>
#include <facetloc/simulation/simulated_place.h>

#include <algorithm>
#include <cmath>

namespace facetloc {
namespace {

// As facetloc_simulate, so that a map of its images is a map of ours.
constexpr std::uint64_t kRunSeeds = 64;  // seeds per place, for its runs
constexpr int kBoxes = 16;               // in a room

/** A Kinect of another resolution, its centre where PCL takes it to be: in the middle. */
Intrinsics centredKinect(int width) {
  const Intrinsics kinect = kinectIntrinsics();
  const double scale = static_cast<double>(width) / kinect.width;
  const int height = static_cast<int>(std::lround(kinect.height * scale));
  const double f = kinect.fx * scale;
  return {width, height, f, f, (width - 1) / 2.0, (height - 1) / 2.0};
}

}  // namespace

SceneSource::SceneSource(const SceneFile& file)
    : file_(file), simulated_camera_(centredKinect(file.width), file.noise, file.seed) {
  camera_ = simulated_camera_.camera();
  mounting_ = file.drive.mounting();
  rate_ = std::max(1, static_cast<int>(std::lround(file.pace.rate)));
  const bool is_map = file.run == "map";
  const std::uint64_t seed = kRunSeeds * file.seed + (is_map ? 0 : 1);
  const auto frames = static_cast<std::size_t>(file.frames) + static_cast<std::size_t>(file.jump);
  try {
    if (file.scene == "room") {
      scene_ = randomRoom(file.seed, kBoxes);
      poses_ = simulateDrive(scene_, frames, file.drive, seed, {}, file.pace);
    } else {
      SimulatedPlace place = simulatedPlace(file.scene, file.seed);
      poses_ = simulateDrive(is_map ? place.mapping_route : place.query_route, frames, file.drive, seed,
                             file.pace);
      scene_ = std::move(is_map ? place.mapped : place.later);
    }
  } catch (const std::exception& e) {
    throw IoError("scene " + file.scene, e.what());
  }
  const auto left_out = file.jump_at > 0 && file.jump_at < file.frames ? poses_.begin() + file.jump_at
                                                                       : poses_.end() - file.jump;
  poses_.erase(left_out, left_out + file.jump);
}

std::uint64_t SceneSource::stamp(std::size_t index) const {
  return static_cast<std::uint64_t>(std::llround(1e6 * static_cast<double>(index) / file_.pace.rate));
}

void SceneSource::read(std::size_t index, std::uint16_t* depth) const {
  toMillimetres(simulated_camera_.render(scene_, poses_.at(index), index).depth, depth);
}

}  // namespace facetloc
