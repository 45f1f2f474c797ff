// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>
#include <facetloc/features/gravity.h>
#include <facetloc/features/params.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

/** \file
 * Measurements beside depth images: wheel odometry, gravity, and the poses of a mapping run, with errors. */

namespace facetloc {

/** \brief Errors of the odometry of a robot with two drive wheels.
 *
 * A step is the motion of the base on the floor from one image to the next. The distance that the wheels roll
 * in it is its length and half the wheel track times its turn. The step is measured as long as it is, times 1
 * + s, plus white noise; its turn with white noise; both noises have variances that grow with that distance,
 * so that position and heading do a random walk. s is drawn once for a run. */
struct WheelOdometryParams {
  static constexpr const char* kTitle = "Errors of the wheel odometry";
  double scale_std = 0.02;
  double length_std = 0.01;
  double heading_std_deg = 1;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("scale_std", p.scale_std, 0.0, 0.5,
          "Error of all lengths of a run, drawn once, standard deviation as a share.");
    visit("length_std", p.length_std, 0.0, 1.0,
          "Random error of the path length, standard deviation after 1 m [m]; grows with its root.");
    visit("heading_std_deg", p.heading_std_deg, 0.0, 90.0,
          "Random error of the heading, standard deviation after 1 m [deg]; grows with the root of the path "
          "length.");
  }
};

/** \brief The odometry of a robot on a drive: poses T_o_b of its base on a level plane, the first
 * one the identity, which drift from the true ones. Same seed, same errors.
 *
 * \param T_w_b the true poses (x forward, y left, z up, origin on the floor), which may tilt. */
std::vector<Eigen::Isometry3d> simulateOdometry(const std::vector<Eigen::Isometry3d>& T_w_b,
                                                const WheelOdometryParams& params, const RobotParams& robot,
                                                std::uint64_t seed);

/** \brief The direction of gravity as a camera with an inertial sensor measures it at each image: in its
 * optical frame, turned by independent errors about each of two horizontal axes. Same seed, same errors.
 * \param T_w_c the true poses, z up \param std of each error [rad] */
std::vector<Gravity> simulateGravity(const std::vector<Eigen::Isometry3d>& T_w_c, double std,
                                     std::uint64_t seed);

/** \brief Errors of the poses that a map is made with: smooth along the way of the camera, so that
 * neighbouring images agree and a place that is passed again is somewhere else. */
struct MapPoseErrors {
  static constexpr const char* kTitle = "Errors of the poses of a mapping run";
  double translation_std = 0;   ///< along each axis [m]
  double rotation_std_deg = 0;  ///< about each axis
  double length = 3;            ///< shortest wavelength along the way [m]; the longest is three times that

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("translation_std", p.translation_std, 0.0, 10.0,
          "Error of positions along each axis, standard deviation [m].");
    visit("rotation_std_deg", p.rotation_std_deg, 0.0, 90.0,
          "Error of orientations about each axis, standard deviation [deg].");
    visit("length", p.length, 0.1, 1e4,
          "Path length of the camera over which the errors change [m]; a radian counts as a metre.");
  }
  bool any() const { return translation_std > 0 || rotation_std_deg > 0; }
};

/** \brief True poses T_w_c with such errors. Same seed, same errors. */
std::vector<Eigen::Isometry3d> simulateMapPoses(const std::vector<Eigen::Isometry3d>& T_w_c,
                                                const MapPoseErrors& errors, std::uint64_t seed);

}  // namespace facetloc
