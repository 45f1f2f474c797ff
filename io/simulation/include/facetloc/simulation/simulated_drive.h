// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>
#include <facetloc/features/params.h>
#include <facetloc/simulation/simulated_place.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

/** \file
 * Drives and runs through simulated places: the same images from the simulating tool, virtual cameras and
 * Python. */

namespace facetloc {

constexpr double kSwayLength = 5;  ///< period of a swaying heading along the line that is driven [m]

/** \brief How a robot with a camera drives, and when it takes an image. */
struct DriveParams {
  static constexpr const char* kTitle = "Drive of the robot";
  double camera_height = 1.0;
  double camera_tilt_deg = 10;
  double step = 0.5;
  double turn_deg = 5;
  double sway_deg = 0;
  double clearance = 0.5;
  RobotParams robot;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("camera_height", p.camera_height, 0.0, 100.0, "Height of the camera above the floor [m].",
          kForUsers);
    visit("camera_tilt_deg", p.camera_tilt_deg, -90.0, 90.0, "Tilt of the camera downwards [deg].",
          kForUsers);
    visit("step", p.step, 0.01, 10.0, "Distance of the robot between images [m].");
    visit("turn_deg", p.turn_deg, 0.1, 180.0, "Turn of the robot between images [deg].");
    visit("sway_deg", p.sway_deg, 0.0, 90.0, "Amplitude of the heading about the line that is driven [deg].");
    visit("clearance", p.clearance, 0.0, 10.0,
          "Distance that the robot keeps from walls and boxes of a room [m].");
    visit("robot", p.robot);
  }
  CameraMounting mounting() const { return {camera_height, camera_tilt_deg}; }
};

/** \brief How fast a robot drives, and its camera takes images at most. */
struct PaceParams {
  static constexpr const char* kTitle = "Pace of the robot";
  double rate = 30;
  double speed = 0.5;
  double turn_rate_deg = 45;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("rate", p.rate, 0.1, 1000.0,
          "Frame rate of the continuous drive, and upper limit for other runs [Hz].", kForUsers);
    visit("speed", p.speed, 0.01, 10.0, "Speed of the robot straight on [m/s].", kForUsers);
    visit("turn_rate_deg", p.turn_rate_deg, 1.0, 360.0, "Turn rate of the robot on the spot [deg/s].");
  }
};

/** \brief End of a route, at its last waypoint. */
enum class RouteEnd { go_round, stop };

/** \brief Camera poses T_w_c of a drive along a route, again and again until there are enough, or to its end
 * (z up, floor at z = 0). The same arguments give the same drive.
 *
 * With a pace, an image is taken every 1/rate s instead of after each step or turn, and the floor is uneven
 * as a floor is: of the same height whenever a wheel comes to the same place. */
std::vector<Eigen::Isometry3d> simulateDrive(const Route& route, std::size_t frames,
                                             const DriveParams& params, std::uint64_t seed,
                                             const std::optional<PaceParams>& pace = {},
                                             RouteEnd end = RouteEnd::go_round);

/** \brief Camera poses T_w_c of a drive through a closed room: from one free place to the next in sight,
 * mostly to where it has not been, with a look around at each.
 *
 * \param start where it begins, so that two drives can be of the same part of a room; a free place by
 * default. Throws std::runtime_error if the room leaves no place to drive. */
std::vector<Eigen::Isometry3d> simulateDrive(const SimulatedWorld& world, std::size_t frames,
                                             const DriveParams& params, std::uint64_t seed,
                                             const std::optional<Eigen::Vector2d>& start = {},
                                             const std::optional<PaceParams>& pace = {});

/** \brief A route repeated `rounds` times: first as it is, then each time on another line, its waypoints
 * displaced by up to 0.1 m in x and y. Same seed, same displacements. */
Route roundsOf(const Route& route, int rounds, std::uint64_t seed);

/** \brief When a robot at this pace takes images where its base is at these poses T_w_b (x forward, z up)
 * [s], beginning with 0: a step takes as long as its way over the floor or as its turn, whichever
 * is longer, and at least 1/rate. */
std::vector<double> drivingTimes(const std::vector<Eigen::Isometry3d>& T_w_b, const PaceParams& pace = {});

/** \brief The poses T_w_b of a robot's base, by the poses T_w_c of its camera. */
std::vector<Eigen::Isometry3d> basePoses(const std::vector<Eigen::Isometry3d>& T_w_c,
                                         const CameraMounting& mounting);

constexpr const char* kRoomName = "room";  ///< A furnished room, beside the simulatedPlaceNames().
constexpr std::uint64_t kRunSeeds = 64;    ///< Seeds reserved for the runs of one place.
constexpr std::uint64_t kMappingRun = 0, kLaterRun = 1;

/** \brief Seed of a run. \param run 0 to kRunSeeds - 1 */
constexpr std::uint64_t runSeed(std::uint64_t place_seed, std::uint64_t run) {
  return kRunSeeds * place_seed + run;
}

/** \brief A random room with enough boxes for most views to show planes of three directions. */
SimulatedWorld furnishedRoom(std::uint64_t seed);

/** \brief A Kinect's intrinsics for images of that width, with the principal point in the middle, where PCL
 * assumes it. */
Intrinsics centredKinect(int width);

/** \brief The poses T_w_c of a camera on its way through a world. */
struct SimulatedRun {
  SimulatedWorld world;
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
