// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/registration/floor_update.h>

#include <Eigen/Cholesky>

namespace facetloc {

FloorPlane floorUnder(const std::vector<Eigen::Isometry3d>& T_w_c, const CameraMounting& mounting) {
  const Eigen::Isometry3d T_c_b = mounting.T_b_c().inverse();
  Eigen::Vector3d up = Eigen::Vector3d::Zero(), place = Eigen::Vector3d::Zero();
  for (const Eigen::Isometry3d& T : T_w_c) {
    const Eigen::Isometry3d T_w_b = T * T_c_b;
    up += T_w_b.linear().col(2);
    place += T_w_b.translation();
  }
  FloorPlane floor;
  floor.normal = up.normalized();
  floor.distance = floor.normal.dot(place) / static_cast<double>(T_w_c.size());
  return floor;
}

PoseWithCovariance updatedByFloor(const PoseWithCovariance& T_w_c, const CameraMounting& mounting,
                                  const FloorPlane& floor, const Eigen::Matrix3d& covariance) {
  const Eigen::Isometry3d T_w_b = T_w_c.T * mounting.T_b_c().inverse();
  const Eigen::Vector3d x = T_w_b.linear().col(0), y = T_w_b.linear().col(1);
  const Eigen::Vector3d arm = T_w_b.translation() - T_w_c.T.translation();  // turns with the camera
  const Eigen::Vector3d& n = floor.normal;

  // Roll, pitch and height of the base about the floor: its axes lean against the normal.
  const Eigen::Vector3d found(n.dot(y), -n.dot(x), n.dot(T_w_b.translation()) - floor.distance);
  Eigen::Matrix<double, 3, 6> H = Eigen::Matrix<double, 3, 6>::Zero();
  H.block<1, 3>(0, 0) = y.cross(n).transpose();
  H.block<1, 3>(1, 0) = -x.cross(n).transpose();
  H.block<1, 3>(2, 0) = arm.cross(n).transpose();
  H.block<1, 3>(2, 3) = n.transpose();

  const Eigen::Matrix3d S = H * T_w_c.P * H.transpose() + covariance;
  const Eigen::Matrix<double, 6, 3> K = S.ldlt().solve(H * T_w_c.P).transpose();
  PoseWithCovariance out;
  out.T = perturbed(T_w_c.T, -K * found);
  const Matrix6d left = Matrix6d::Identity() - K * H;  // Joseph form: stays positive definite
  out.P = left * T_w_c.P * left.transpose() + K * covariance * K.transpose();
  return out;
}

}  // namespace facetloc
