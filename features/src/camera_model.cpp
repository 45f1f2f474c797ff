// SPDX-License-Identifier: BSD-3-Clause
#include "base/pose_axes.h"

#include <facetloc/features/camera_model.h>
#include <facetloc/features/pose.h>

#include <cmath>

namespace facetloc {

Intrinsics Intrinsics::subsampled(int step) const {
  // Pixel (u, v) of the small image is pixel (step u, step v) of the large one.
  return {(width + step - 1) / step, (height + step - 1) / step, fx / step, fy / step, cx / step, cy / step};
}

bool Intrinsics::valid() const {
  return width > 0 && height > 0 && fx > 0 && fy > 0 && std::isfinite(fx) && std::isfinite(fy) &&
         std::isfinite(cx) && std::isfinite(cy);
}

bool Intrinsics::operator==(const Intrinsics& o) const {
  return width == o.width && height == o.height && fx == o.fx && fy == o.fy && cx == o.cx && cy == o.cy;
}

Intrinsics kinectIntrinsics() {
  return {640, 480, 584.70194597700402, 585.70332900816618, 318.55964537649561, 256.14501544470505};
}

Eigen::Matrix3d pointCovariance(const Eigen::Vector3d& p, const Intrinsics& camera, double pixel_std,
                                double inverse_depth_std) {
  const double z = p.z();
  Eigen::Matrix3d S = std::pow(z * inverse_depth_std, 2) * p * p.transpose();
  S(0, 0) += std::pow(z * pixel_std / camera.fx, 2);
  S(1, 1) += std::pow(z * pixel_std / camera.fy, 2);
  return S;
}

Eigen::Isometry3d CameraMounting::T_b_c() const {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = expSO3({0, 0, pan_deg * kDegree}) * internal::opticalInBase() *
               expSO3({-tilt_deg * kDegree, 0, 0}) * expSO3({0, 0, roll_deg * kDegree});
  T.translation() << x, y, height;
  return T;
}

bool CameraMounting::agreesWith(const CameraMounting& other) const {
  constexpr double kHeight = 0.05, kAngle = 5;  // [m], [deg]
  return std::abs(height - other.height) <= kHeight && std::abs(tilt_deg - other.tilt_deg) <= kAngle &&
         std::abs(std::remainder(roll_deg - other.roll_deg, 360)) <= kAngle;
}

}  // namespace facetloc
