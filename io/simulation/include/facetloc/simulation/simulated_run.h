// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/simulation/simulated_drive.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

/** \file
 * Runs through simulated places: the same images from the simulating tool, virtual cameras and Python. */

namespace facetloc {

constexpr const char* kRoomName = "room";  ///< A furnished room, beside the simulatedPlaceNames().
constexpr std::uint64_t kRunSeeds = 64;    ///< Seeds reserved for the runs of one place.
constexpr std::uint64_t kMappingRun = 0, kLaterRun = 1;

/** \brief Seed of a run. \param run 0 to kRunSeeds - 1 */
constexpr std::uint64_t runSeed(std::uint64_t place_seed, std::uint64_t run) {
  return kRunSeeds * place_seed + run;
}

/** \brief A random room with enough boxes for most views to show planes of three directions. */
Scene furnishedRoom(std::uint64_t seed);

/** \brief A Kinect's intrinsics for images of that width, with the principal point in the middle, where PCL
 * assumes it. */
Intrinsics centredKinect(int width);

/** \brief The poses T_w_c of a camera on its way through a scene. */
struct SimulatedRun {
  Scene scene;
  std::vector<Eigen::Isometry3d> poses;
};

/** \brief The mapping run or the later one through a place.
 * \param place kRoomName or one of simulatedPlaceNames(); throws std::invalid_argument for another name
 * \param run kMappingRun or kLaterRun
 * \param frames largest number of poses
 * \param end at the last waypoint; by default as the place says */
SimulatedRun simulatedRun(const std::string& place, std::uint64_t seed, std::uint64_t run, std::size_t frames,
                          const DriveParams& params, const std::optional<PaceParams>& pace = {},
                          std::optional<RouteEnd> end = {});

}  // namespace facetloc
