// SPDX-License-Identifier: BSD-3-Clause
#include "tools/drive.h"

namespace facetloc {

std::optional<PoseWithCovariance> MeasuredMotion::until(double stamp) {
  if (!odometry_) return {};
  const std::optional<Eigen::Isometry3d> T_before_now = steps_.to(odometry_(stamp));
  if (!T_before_now) return {};
  return motionByOdometry(*T_before_now, mounting_, error_);
}

Localization Drive::add(const View& view, double stamp) {
  const std::optional<PoseWithCovariance> motion = motion_.until(stamp);
  Localization answer = localizer_.update(view, stamp, motion);
  if (smoothing_) views_.push_back({view, stamp, motion, answer});
  return answer;
}

}  // namespace facetloc
