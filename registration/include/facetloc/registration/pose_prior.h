// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>
#include <facetloc/features/so3.h>

#include <optional>

namespace facetloc {

/** \brief What is known of the camera pose relative to a local model before any matching (paper II.B, METHOD
 * 6). */
struct PosePriorParams {
  double rotation_std_deg = 20;    ///< heading of the robot, or any axis where the mounting is unknown
  double translation_std = 1.0;    ///< in the floor plane, or any axis where the mounting is unknown [m]
  double floor_std = 0.005;        ///< deviation of the floor under each wheel [m]
  double wheel_track = 0.325;      ///< distance of the drive wheels [m]
  double caster_distance = 0.165;  ///< of the caster behind the axle [m]

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& field) {
    field("prior_rotation_deg", p.rotation_std_deg, 0.01, 180.0,
          "Prior of the heading, standard deviation [deg]; of every axis where the mounting is unknown.");
    field("prior_translation", p.translation_std, 0.001, 100.0,
          "Prior of the position on the floor, standard deviation [m]; of every axis where the mounting is "
          "unknown.");
    field("floor_std", p.floor_std, 1e-6, 1.0, "Unevenness of the floor, standard deviation [m].");
    field("wheel_track", p.wheel_track, 0.01, 10.0, "Distance of the drive wheels [m].");
    field("caster_distance", p.caster_distance, 0.01, 10.0, "Distance of the caster behind the axle [m].");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief Covariance of (roll, pitch, height) of the robot base on an uneven floor, METHOD eq. (6.1). */
Eigen::Matrix3d floorCovariance(const PosePriorParams& params);

/** \brief The motion (phi, t) of a camera in its own axes by a small one of the robot base in the base's
 * axes, 6x6, METHOD eq. (6.2). */
Matrix6d cameraMotion(const CameraMounting& mounting);

/** \brief Covariance of T_m_c about an expected pose, order (phi, t) in the model's camera axes, METHOD eq.
 * (6.2): planar motion and uneven floor, under the robot and under that of the model, seen through the camera
 * mounting; isotropic without one. Contains what tilts of the model's robot do to the height at the distance
 * that the planar motion allows. */
Matrix6d posePrior(const std::optional<CameraMounting>& mounting, const PosePriorParams& params = {},
                   const Eigen::Isometry3d& T_m_c = Eigen::Isometry3d::Identity());

/** \brief What the floor alone tells of it about the identity: the information of roll, pitch and height,
 * none of heading and of the position on the floor; zero without a mounting. */
Matrix6d floorInformation(const std::optional<CameraMounting>& mounting, const PosePriorParams& params = {});

}  // namespace facetloc
