// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/simulation/simulated_camera.h>
#include <facetloc/simulation/simulated_drive.h>

#include <cstdint>
#include <filesystem>
#include <string>

namespace facetloc {

/** \brief A .scene file: the camera of a robot that drives through a simulated place.
 *
 *     scene = office    # office, home, hall, or room: one room with random boxes
 *     seed = 1          # as facetloc_simulate: the same place and noise
 *     run = query       # query (later, when things have moved) or map
 *     width = 320       # width of the images [px], 4:3
 *     frames = 1800
 *     jump_at = 900     # the camera is carried away before this image ...
 *     jump = 600        # ... to where it would have been this number of images later
 *
 * and the parameters of facetloc_simulate in the groups drive, pace (rate, speed, turn_rate_deg) and sensor,
 * by their names without the group. All have defaults but scene. One `key = value` per line, # starts a
 * comment. */
struct SceneFile {
  std::string scene;
  std::string run = "query";
  std::uint64_t seed = 1;
  int width = 320;
  int frames = 1800;
  int jump_at = 0;  ///< 0 = never
  int jump = 0;
  DriveParams drive;
  PaceParams pace;
  SimulatedNoise noise;
};

/** \brief Throws IoError with the line for unknown keys and values that are impossible. */
SceneFile readSceneFile(const std::filesystem::path& path);

}  // namespace facetloc
