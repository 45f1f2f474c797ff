// SPDX-License-Identifier: BSD-3-Clause
#include "random.h"
#include "waves.h"

#include <facetloc/features/pose.h>
#include <facetloc/simulation/simulated_sensors.h>

#include <algorithm>
#include <cmath>

namespace facetloc {
namespace {

// Purposes of the seed, which may be the drive's.
constexpr std::uint64_t kOdometry = 1, kGravity = 2, kDrift = 1;

/** A place on the floor plan and the heading there. */
Eigen::Isometry2d onFloor(const Eigen::Isometry3d& T_w_b) {
  const Eigen::Vector3d ahead = T_w_b.linear().col(0);
  return Eigen::Translation2d(T_w_b.translation().head<2>()) *
         Eigen::Rotation2Dd(std::atan2(ahead.y(), ahead.x()));
}

double headingOf(const Eigen::Isometry2d& T) { return std::atan2(T(1, 0), T(0, 0)); }

Eigen::Isometry3d inSpace(const Eigen::Isometry2d& T) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = expSO3({0, 0, headingOf(T)});
  pose.translation().head<2>() = T.translation();
  return pose;
}

}  // namespace

std::vector<Eigen::Isometry3d> simulateOdometry(const std::vector<Eigen::Isometry3d>& T_w_b,
                                                const WheelOdometryParams& params, const RobotParams& robot,
                                                std::uint64_t seed) {
  Random random(derivedSeed(seed, kOdometry));
  const double scale = 1 + params.scale_std * random.normal();
  std::vector<Eigen::Isometry3d> poses;
  Eigen::Isometry2d T_o_b = Eigen::Isometry2d::Identity();
  for (std::size_t i = 0; i < T_w_b.size(); ++i) {
    if (i > 0) {
      const Eigen::Isometry2d step = onFloor(T_w_b[i - 1]).inverse() * onFloor(T_w_b[i]);
      const double length = step.translation().norm(), turn = headingOf(step);
      const double root = std::sqrt(length + robot.wheel_track / 2 * std::abs(turn));
      const double length_error = params.length_std * root * random.normal();
      const double turn_error = params.heading_std_deg * kDegree * root * random.normal();
      const Eigen::Vector2d direction =
          length > 0 ? Eigen::Vector2d(step.translation() / length) : Eigen::Vector2d::UnitX();
      T_o_b = T_o_b * (Eigen::Translation2d((scale * length + length_error) * direction) *
                       Eigen::Rotation2Dd(turn + turn_error));
    }
    poses.push_back(inSpace(T_o_b));
  }
  return poses;
}

std::vector<Gravity> simulateGravity(const std::vector<Eigen::Isometry3d>& T_w_c, double std,
                                     std::uint64_t seed) {
  constexpr double kLeastStd = 0.001 * kDegree;
  Random random(derivedSeed(seed, kGravity));
  std::vector<Gravity> found;
  for (const Eigen::Isometry3d& T : T_w_c) {
    const Eigen::Vector3d error(std * random.normal(), std * random.normal(), 0);
    const Eigen::Vector3d down = T.linear().transpose() * (expSO3(error) * -Eigen::Vector3d::UnitZ());
    found.push_back(gravityAlong(down, std::max(kLeastStd, std)));
  }
  return found;
}

std::vector<Eigen::Isometry3d> simulateMapPoses(const std::vector<Eigen::Isometry3d>& T_w_c,
                                                const MapPoseErrors& errors, std::uint64_t seed) {
  constexpr double kRadian = 1;   // weight of rotation, as path length of the camera [m]
  constexpr double kLongest = 3;  // wavelength, in terms of the shortest
  checkRanges(errors);
  std::vector<Waves> of_axes;
  for (std::uint64_t axis = 0; axis < 6; ++axis)
    of_axes.emplace_back(errors.length, kLongest * errors.length, Random(derivedSeed(seed, kDrift, axis)));
  std::vector<Eigen::Isometry3d> poses;
  Eigen::Vector3d way = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < T_w_c.size(); ++i) {
    if (i > 0) {
      const Eigen::Isometry3d step = T_w_c[i - 1].inverse() * T_w_c[i];
      way.x() += step.translation().norm() + kRadian * rotationAngle(step.linear());
    }
    Vector6d d;
    for (int axis = 0; axis < 6; ++axis)
      d[axis] =
          (axis < 3 ? errors.rotation_std_deg * kDegree : errors.translation_std) * of_axes[axis].at(way);
    poses.push_back(boxplus(T_w_c[i], d));
  }
  return poses;
}

}  // namespace facetloc
