// SPDX-License-Identifier: BSD-3-Clause
#include "motion/velocity_prior.h"

#include "motion/step_prior.h"

#include <algorithm>

namespace facetloc::internal {
namespace {

constexpr double kLongest = 3;     // time after which a velocity says nothing of the next one [s]
constexpr double kRestless = 1.5;  // sum of |v|^2 of three motions that keep nothing [m^2/s^2]

}  // namespace

void VelocityPrior::add(const Eigen::Isometry3d& T_a_b, double dt) {
  if (!(dt > 0 && dt < kLongest)) return interrupt();
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
  if (velocity_ && dt < kLongest) prior.T.translation() = keptShare() * dt * *velocity_;
  return prior;
}

}  // namespace facetloc::internal
