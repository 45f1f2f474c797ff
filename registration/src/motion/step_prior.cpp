// SPDX-License-Identifier: BSD-3-Clause
#include "motion/step_prior.h"

#include <facetloc/registration/pose_prior.h>

#include <algorithm>

namespace facetloc::internal {
namespace {

constexpr double kDistance = 0.4, kTurnDeg = 20;   // [m, deg]
constexpr double kSpeed = 0.7, kTurnRateDeg = 40;  // speeds of a walk [m/s, deg/s]
constexpr double kShortest = 0.2, kLongest = 3;    // times that a motion is thought to take [s]
constexpr int kSideways = 4;                       // among the motions of a robot base

constexpr double kLongestKept = 3;  // time after which a velocity says nothing of the next one [s]
constexpr double kRestless = 1.5;   // sum of |v|^2 of three motions that keep nothing [m^2/s^2]

}  // namespace

Matrix6d stepCovariance(const std::optional<CameraMounting>& mounting, bool slips) {
  const Matrix6d P = posePrior(mounting, {kTurnDeg, kDistance, {}});
  if (!mounting || slips) return P;
  const Vector6d sideways = cameraMotion(*mounting).col(kSideways);  // motion of the camera, one metre
  return P - (kDistance * kDistance - kSidewaysStd * kSidewaysStd) * sideways * sideways.transpose();
}

Matrix6d motionPrior(double dt, const std::optional<CameraMounting>& mounting) {
  const double time = std::clamp(dt, kShortest, kLongest);
  return posePrior(mounting, {kTurnRateDeg * time, kSpeed * time, {}});
}

SidewaysShift sidewaysShift(const PoseWithCovariance& T_before_after, const CameraMounting& mounting) {
  const Vector6d of_base = cameraMotion(mounting).inverse().row(kSideways).transpose();
  return {of_base.dot(boxminus(T_before_after.T, Eigen::Isometry3d::Identity())),
          of_base.dot(T_before_after.P * of_base)};
}

void VelocityPrior::add(const Eigen::Isometry3d& T_a_b, double dt) {
  if (!(dt > 0 && dt < kLongestKept)) return interrupt();
  const Eigen::Vector3d of_a = T_a_b.translation() / dt;
  if (velocity_) {
    product_ += of_a.dot(*velocity_);
    square_ += velocity_->squaredNorm();
  }
  velocity_ = T_a_b.linear().transpose() * of_a;
}

double VelocityPrior::keptShare() const { return std::clamp(product_ / (square_ + kRestless), 0.0, 1.0); }

PoseWithCovariance VelocityPrior::next(double dt, const std::optional<CameraMounting>& mounting) const {
  PoseWithCovariance prior{Eigen::Isometry3d::Identity(), motionPrior(dt, mounting)};
  if (velocity_ && dt < kLongestKept) prior.T.translation() = keptShare() * dt * *velocity_;
  return prior;
}

}  // namespace facetloc::internal
