// SPDX-License-Identifier: BSD-3-Clause
#include "motion/step_prior.h"

#include <facetloc/registration/pose_prior.h>

namespace facetloc::internal {
namespace {

constexpr double kWay = 0.4, kTurnDeg = 20;  // [m, deg]
constexpr int kSideways = 4;                 // among the motions of a robot base

}  // namespace

Matrix6d stepCovariance(const std::optional<CameraMounting>& mounting, bool slides) {
  PosePriorParams prior;
  prior.translation_std = kWay;
  prior.rotation_std_deg = kTurnDeg;
  Matrix6d P = posePrior(mounting, prior);
  if (!mounting || slides) return P;
  const Vector6d sideways = cameraMotion(*mounting).col(kSideways);  // of the camera, one metre
  return P - (kWay * kWay - kSidewaysStd * kSidewaysStd) * sideways * sideways.transpose();
}

SidewaysShift sidewaysShift(const PoseWithCovariance& T_before_after, const CameraMounting& mounting) {
  const Vector6d of_base = cameraMotion(mounting).inverse().row(kSideways).transpose();
  return {of_base.dot(perturbation(Eigen::Isometry3d::Identity(), T_before_after.T)),
          of_base.dot(T_before_after.P * of_base)};
}

}  // namespace facetloc::internal
