// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/so3.h>

#include <cmath>

namespace facetloc {

Eigen::Matrix3d skew(const Eigen::Vector3d& a) {
  Eigen::Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

Eigen::Matrix3d expSO3(const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  if (angle < 1e-9) return Eigen::Matrix3d::Identity() + skew(phi);
  return Eigen::AngleAxisd(angle, phi / angle).toRotationMatrix();
}

Eigen::Vector3d logSO3(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd a(R);
  return a.angle() * a.axis();
}

Eigen::Matrix3d leftJacobianSO3(const Eigen::Vector3d& phi) {
  const double f = phi.norm();
  const Eigen::Matrix3d K = skew(phi);
  if (f < 1e-5) return Eigen::Matrix3d::Identity() + 0.5 * K + K * K / 6.0;
  return Eigen::Matrix3d::Identity() + (1 - std::cos(f)) / (f * f) * K +
         (f - std::sin(f)) / (f * f * f) * K * K;
}

double rotationAngle(const Eigen::Matrix3d& R) {
  const Eigen::Vector3d twice_sine_axis(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  return std::atan2(0.5 * twice_sine_axis.norm(), 0.5 * (R.trace() - 1.0));
}

Eigen::Matrix3d rotationBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to).toRotationMatrix();
}

}  // namespace facetloc
