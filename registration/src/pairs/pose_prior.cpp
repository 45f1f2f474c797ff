// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/registration/pose_prior.h>

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace facetloc {

Eigen::Matrix3d floorCovariance(const PosePriorParams& p) {
  constexpr double kLeastFloorStd = 1e-6;  // [m], so that covariances are regular
  const double a = p.robot.wheel_track, b = p.robot.caster_distance;
  const double floor_std = std::max(kLeastFloorStd, p.robot.floor_std);
  Eigen::Matrix3d C;  // METHOD 2.1
  C << 2 / (a * a), 0, 0, 0, 3 / (2 * b * b), -1 / (2 * b), 0, -1 / (2 * b), 0.5;
  return floor_std * floor_std * C;
}

Matrix6d cameraMotion(const CameraMounting& mounting) { return adjoint(mounting.T_b_c().inverse()); }

namespace {

constexpr int kOfFloor[3] = {0, 1, 5};  // roll, pitch, height among the motions of the base

// The floor tilts the model's robot about its own place, which lifts or lowers a robot that stands away.
double leverVariance(const PosePriorParams& p) {
  const Eigen::Matrix3d C = floorCovariance(p);
  return p.translation_std * p.translation_std * (C(0, 0) + C(1, 1));
}

}  // namespace

Matrix6d posePrior(const std::optional<CameraMounting>& mounting, const PosePriorParams& p,
                   const Eigen::Isometry3d& T_m_c) {
  const double var_rotation = std::pow(p.rotation_std_deg * kDegree, 2);
  const double var_translation = p.translation_std * p.translation_std;
  Matrix6d Sigma = Matrix6d::Zero();
  if (!mounting) {
    Sigma.diagonal().head<3>().setConstant(var_rotation);
    Sigma.diagonal().tail<3>().setConstant(var_translation);
    return Sigma;
  }
  // Motions of the robot base (omega, v) at the model's base, in its axes. The robot turns about its place.
  const Eigen::Isometry3d T_b_c = mounting->T_b_c(), T_m_b = T_b_c * T_m_c * T_b_c.inverse();
  Vector6d turn = Vector6d::Unit(2);
  turn.tail<3>() = T_m_b.translation().cross(Eigen::Vector3d::UnitZ());
  Sigma = var_rotation * turn * turn.transpose();
  Sigma(3, 3) += var_translation;
  Sigma(4, 4) += var_translation;
  Matrix6d of_floor = Matrix6d::Zero();
  of_floor(kOfFloor, kOfFloor) = floorCovariance(p);
  const Matrix6d Ad = adjoint(T_m_b);
  Sigma += of_floor + Ad * of_floor * Ad.transpose();  // each stands on its own piece of floor
  Sigma(5, 5) += leverVariance(p);
  Matrix6d A = cameraMotion(*mounting);
  A.bottomRows<3>() -= skew(T_m_c.translation()) * A.topRows<3>();  // Jacobian of the camera's position
  return A * Sigma * A.transpose();
}

Matrix6d floorInformation(const std::optional<CameraMounting>& mounting, const PosePriorParams& p) {
  if (!mounting) return Matrix6d::Zero();
  const Matrix6d of_base = cameraMotion(*mounting).inverse();
  const Eigen::Matrix<double, 3, 6> of_floor = of_base(kOfFloor, Eigen::all);
  Eigen::Matrix3d C = 2 * floorCovariance(p);
  C(2, 2) += leverVariance(p);
  return of_floor.transpose() * C.inverse() * of_floor;
}

// The error along the path is the same for some metres, as a wrong radius of a wheel makes it.
PoseWithCovariance motionByOdometry(const Eigen::Isometry3d& T_before_now,
                                    const std::optional<CameraMounting>& mounting,
                                    const OdometryError& error) {
  constexpr double kAlike = 10;             // distance along which the error stays [m]
  constexpr double kMetresPerRadian = 0.2;  // that the wheels of a robot roll when it turns
  const double distance = T_before_now.translation().norm();
  const double rolled = distance + kMetresPerRadian * rotationAngle(T_before_now.linear());
  PosePriorParams prior;
  prior.translation_std = error.drift * std::sqrt(distance * kAlike) + error.least_translation;
  prior.rotation_std_deg = error.turn_deg * std::sqrt(rolled) + error.least_rotation_deg;
  return {T_before_now, posePrior(mounting, prior, T_before_now)};
}

}  // namespace facetloc
