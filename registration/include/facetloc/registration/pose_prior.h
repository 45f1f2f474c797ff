// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>
#include <facetloc/features/pose.h>

#include <optional>

namespace facetloc {

/** \brief Knowledge of the camera pose relative to a local model before any matching (paper II.B, METHOD
 * 2). */
struct PosePriorParams {
  static constexpr const char* kTitle = "Prior of the pose relative to a local model";
  double rotation_std_deg = 20;
  double translation_std = 1.0;
  RobotParams robot;  ///< where the mounting of the camera is known

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit(
        "rotation_std_deg", p.rotation_std_deg, 0.01, 180.0,
        "Prior of a robot's heading, standard deviation [deg]; of every axis for a camera whose mounting is "
        "unknown. Raise it for a map driven less densely than every 15 deg.",
        kForUsers);
    visit(
        "translation_std", p.translation_std, 0.001, 100.0,
        "Prior of a robot's position on the floor, standard deviation [m]; of every axis for a camera whose "
        "mounting is unknown. Raise it for a map driven less densely than every 0.5 m.",
        kForUsers);
    visit("robot", p.robot);
  }
};

/** \brief Covariance of (roll, pitch, height) of the robot base on an uneven floor, METHOD 2.1. */
Eigen::Matrix3d floorCovariance(const PosePriorParams& params);

/** \brief The motion (phi, t) of a camera in its own axes by a small one of the robot base in the base's
 * axes, 6x6, METHOD 2.2. */
Matrix6d cameraMotion(const CameraMounting& mounting);

/** \brief Covariance of T_m_c about an expected pose, order (phi, t) in the model's camera axes, METHOD
 * 2.2: planar motion and uneven floor, under the robot and under the model's robot, seen through the camera
 * mounting; isotropic without one. Includes the effect of tilts of the model's robot on the height at the
 * distance that the planar motion allows. */
Matrix6d posePrior(const std::optional<CameraMounting>& mounting, const PosePriorParams& params = {},
                   const Eigen::Isometry3d& T_m_c = Eigen::Isometry3d::Identity());

/** \brief Its information about the identity by the floor alone: of roll, pitch and height,
 * none of heading and of the position on the floor; zero without a mounting. */
Matrix6d floorInformation(const std::optional<CameraMounting>& mounting, const PosePriorParams& params = {});

/** \brief How well an odometry measures motions. */
struct OdometryError {
  static constexpr const char* kTitle = "Error of a given odometry";
  double drift = 0.02;
  double turn_deg = 1;
  double least_translation = 1e-4;  ///< error of a step of any length, standard deviation [m]
  double least_rotation_deg = 0.01;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("drift", p.drift, 0.0, 1.0,
          "Error of a given odometry along its path, standard deviation as a share of the path.", kForUsers);
    visit("turn_deg", p.turn_deg, 0.0, 180.0,
          "Error of the heading of a given odometry after one metre, standard deviation [deg].", kForUsers);
  }
};

/** \brief A motion of the camera that an odometry has measured, T_before_now, with its covariance
 * (mapping/METHOD 1.4): in the floor plane for a camera that is mounted on a robot, whose wheels tell
 * nothing of how it leans on an uneven floor; isotropic without a mounting. */
PoseWithCovariance motionByOdometry(const Eigen::Isometry3d& T_before_now,
                                    const std::optional<CameraMounting>& mounting,
                                    const OdometryError& error = {});

}  // namespace facetloc
