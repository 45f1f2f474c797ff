// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>
#include <facetloc/features/params.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

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
  void validate() const { checkRanges(*this); }
};

/** \brief The odometry of a robot on a drive: poses T_o_b of its base on a level plane, the first
 * one the identity, which drift from the true ones. Same seed, same errors.
 *
 * \param T_w_b the true poses (x forward, y left, z up, origin on the floor), which may tilt. */
std::vector<Eigen::Isometry3d> simulateOdometry(const std::vector<Eigen::Isometry3d>& T_w_b,
                                                const WheelOdometryParams& params, const RobotParams& robot,
                                                std::uint64_t seed);

}  // namespace facetloc
