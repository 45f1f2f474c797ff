// SPDX-License-Identifier: BSD-3-Clause
#include "scene_source.h"

#include "millimetres.h"

#include <facetloc/io/error.h>
#include <facetloc/simulation/simulated_run.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace facetloc {

SceneSource::SceneSource(const SceneFile& file)
    : file_(file), simulated_camera_(centredKinect(file.width), file.noise, file.seed) {
  camera_ = simulated_camera_.camera();
  mounting_ = file.drive.mounting();
  rate_ = std::max(1, static_cast<int>(std::lround(file.pace.rate)));
  const bool is_map = file.run == "map";
  const auto frames = static_cast<std::size_t>(file.frames) + static_cast<std::size_t>(file.jump);
  try {
    SimulatedRun run = simulatedRun(file.scene, file.seed, is_map ? kMappingRun : kLaterRun, frames,
                                    file.drive, file.pace, RouteEnd::go_round);
    scene_ = std::move(run.scene);
    poses_ = std::move(run.poses);
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
