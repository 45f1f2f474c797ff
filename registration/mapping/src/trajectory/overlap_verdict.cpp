// SPDX-License-Identifier: BSD-3-Clause
#include "trajectory/overlap_verdict.h"

#include "depth/depth_consistency.h"
#include "shared/pose_fusion.h"
#include "shared/pose_radius.h"

#include <facetloc/features/chi_square.h>
#include <facetloc/registration/pose_prior.h>

#include <algorithm>

namespace facetloc::internal {
namespace {

constexpr double kUnknown = 100;  // standard deviation of what two views do not tell [m, rad]
constexpr double kFarEllipsoid = chiSquareQuantile(6, 0.999);
constexpr PoseRadius kSameTrajectory{0.1, 1};

}  // namespace

PoseWithCovariance measured(const PlacedView& placed) {
  Matrix6d information = placed.information;
  information.diagonal().array() += 1 / (kUnknown * kUnknown);
  return {placed.T_a_b, withSharedErrors(symmetricInverse(information))};
}

OverlapVerdict verdictOn(const Eigen::Isometry3d& T_a_b, const View& a, const View& b,
                         const Comparison& compared) {
  const DepthComparison comparison(DepthCalibration{});
  const DepthAgreement seen = comparison.compareBoth(b.depth, a.depth, T_a_b, kFineColumns);
  const double judged = seen.agree + seen.contradict;
  const double pixels = 2.0 * gridPoints(b.depth.camera.width, gridStep(b.depth, kFineColumns)) *
                        gridPoints(b.depth.camera.height, gridStep(b.depth, kFineColumns));
  if (judged < kLeastOverlap * pixels) return OverlapVerdict::says_nothing;
  const bool is_elsewhere = compared.placed && !compared.anywhere &&
                            !kSameTrajectory.joins(compared.placed->T_a_b, T_a_b) &&
                            squaredMahalanobis(measured(*compared.placed), T_a_b) > kFarEllipsoid;
  const bool agrees = seen.agree >= kLeastAgreement * judged;
  return agrees && !is_elsewhere ? OverlapVerdict::confirms : OverlapVerdict::contradicts;
}

}  // namespace facetloc::internal
