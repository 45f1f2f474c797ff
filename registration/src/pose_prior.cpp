// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/registration/pose_prior.h>

#include <Eigen/LU>

#include <cmath>

namespace facetloc {

Eigen::Matrix3d floorCovariance(const PosePriorParams& p) {
  const double a = p.wheel_track, b = p.caster_distance;
  Eigen::Matrix3d C;  // Eq. (6.1) of METHOD
  C << 2 / (a * a), 0, 0, 0, 3 / (2 * b * b), -1 / (2 * b), 0, -1 / (2 * b), 0.5;
  return p.floor_std * p.floor_std * C;
}

Matrix6d cameraMotion(const CameraMounting& mounting) {
  const Eigen::Isometry3d T_b_c = mounting.T_b_c();
  const Eigen::Matrix3d R_c_b = T_b_c.linear().transpose();
  Matrix6d A = Matrix6d::Zero();
  A.topLeftCorner<3, 3>() = R_c_b;
  A.bottomLeftCorner<3, 3>() = -R_c_b * skew(T_b_c.translation());
  A.bottomRightCorner<3, 3>() = R_c_b;
  return A;
}

namespace {

constexpr int kOfFloor[3] = {0, 1, 5};  // roll, pitch, height among the motions of the base

// Of the pose of one robot relative to another: each stands on its own piece of floor.
Eigen::Matrix3d relativeFloorCovariance(const PosePriorParams& p) { return 2 * floorCovariance(p); }

}  // namespace

Matrix6d posePrior(const std::optional<CameraMounting>& mounting, const PosePriorParams& p) {
  const double var_rotation = std::pow(p.rotation_std_deg * kDegree, 2);
  const double var_translation = p.translation_std * p.translation_std;
  Matrix6d Sigma = Matrix6d::Zero();
  if (!mounting) {
    Sigma.diagonal().head<3>().setConstant(var_rotation);
    Sigma.diagonal().tail<3>().setConstant(var_translation);
    return Sigma;
  }
  // Disturbance of the base (w_x, w_y, w_z, v_x, v_y, v_z).
  Sigma.diagonal() << 0, 0, var_rotation, var_translation, var_translation, 0;
  const Eigen::Matrix3d C = relativeFloorCovariance(p);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) Sigma(kOfFloor[i], kOfFloor[j]) += C(i, j);
  const Matrix6d A = cameraMotion(*mounting);
  return A * Sigma * A.transpose();
}

Matrix6d floorInformation(const std::optional<CameraMounting>& mounting, const PosePriorParams& p) {
  if (!mounting) return Matrix6d::Zero();
  const Matrix6d of_base = cameraMotion(*mounting).inverse();
  Eigen::Matrix<double, 3, 6> of_floor;
  for (int i = 0; i < 3; ++i) of_floor.row(i) = of_base.row(kOfFloor[i]);
  return of_floor.transpose() * relativeFloorCovariance(p).inverse() * of_floor;
}

}  // namespace facetloc
