// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>
#include <facetloc/features/params.h>
#include <facetloc/simulation/simulated_place.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace facetloc {

/** \brief How a robot with a camera drives, and when it takes an image. */
struct DriveParams {
  double camera_height = 1.0;      ///< [m]
  double camera_tilt_deg = 10;     ///< downwards
  double step = 0.5;               ///< an image is taken after so much driving [m] ...
  double turn_deg = 5;             ///< ... or turning, as in the paper
  double sway_deg = 0;             ///< amplitude of the heading about the line that is driven
  double sway_length = 5;          ///< period of that [m]
  double clearance = 0.5;          ///< from walls and boxes of a room [m]
  double floor_std = 0.005;        ///< deviation of the floor under each wheel [m]
  double wheel_track = 0.325;      ///< [m]
  double caster_distance = 0.165;  ///< [m]

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& field) {
    field("camera_height", p.camera_height, 0.0, 100.0, "Height of the camera above the floor [m].");
    field("camera_tilt_deg", p.camera_tilt_deg, -90.0, 90.0, "Tilt of the camera downwards [deg].");
    field("step", p.step, 0.01, 10.0, "An image is taken after so much driving ... [m].");
    field("turn_deg", p.turn_deg, 0.1, 180.0, "... or turning [deg].");
    field("sway_deg", p.sway_deg, 0.0, 90.0, "Amplitude of the heading about the line that is driven [deg].");
    field("sway_length", p.sway_length, 0.1, 1000.0, "Period of that along the line [m].");
    field("clearance", p.clearance, 0.0, 10.0,
          "Distance that the robot keeps from walls and boxes of a room [m].");
    field("floor_std", p.floor_std, 0.0, 1.0,
          "Unevenness of the floor under each wheel, standard deviation [m].");
    field("wheel_track", p.wheel_track, 0.01, 10.0, "Distance of the drive wheels [m].");
    field("caster_distance", p.caster_distance, 0.01, 10.0, "Distance of the caster behind the axle [m].");
  }
  void validate() const { checkRanges(*this); }
  CameraMounting mounting() const { return {camera_height, camera_tilt_deg}; }
};

/** \brief A drive in time: the camera takes images by the clock, whatever the robot does. */
struct PaceParams {
  double rate = 30;           ///< images per second
  double speed = 0.5;         ///< straight on [m/s]
  double turn_rate_deg = 45;  ///< on the spot [deg/s]

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& field) {
    field("rate", p.rate, 0.1, 1000.0, "Images per second of the continuous drive.");
    field("speed", p.speed, 0.01, 10.0, "Its speed straight on [m/s].");
    field("turn_rate_deg", p.turn_rate_deg, 1.0, 360.0, "Its speed of turning on the spot [deg/s].");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief Camera poses T_w_c of a drive along a route, again and again until there are enough (z up, floor at
 * z = 0). The same arguments give the same drive.
 *
 * With a pace, an image is taken every 1/rate s instead of after each step or turn, and the floor is uneven
 * as a floor is: of the same height whenever a wheel comes to the same place. */
std::vector<Eigen::Isometry3d> simulateDrive(const Route& route, std::size_t frames,
                                             const DriveParams& params, std::uint64_t seed,
                                             const std::optional<PaceParams>& pace = {});

/** \brief Camera poses T_w_c of a drive through a closed room: from one free place to the next in sight,
 * mostly to where it has not been, with a look around at each.
 *
 * \param start where it begins, so that two drives can be of the same part of a room; a free place by
 * default. Throws std::runtime_error if the room leaves no place to drive. */
std::vector<Eigen::Isometry3d> simulateDrive(const Scene& scene, std::size_t frames,
                                             const DriveParams& params, std::uint64_t seed,
                                             const std::optional<Eigen::Vector2d>& start = {},
                                             const std::optional<PaceParams>& pace = {});

}  // namespace facetloc
