// SPDX-License-Identifier: BSD-3-Clause
#include "trajectory/overlap_verdict.h"

#include "depth/depth_consistency.h"
#include "poses/pose_fusion.h"
#include "poses/pose_radius.h"

#include <facetloc/registration/pose_prior.h>

#include <algorithm>

namespace facetloc::internal {
namespace {

constexpr double kUnknown = 100;  // standard deviation of motions that two views leave free [m, rad]
constexpr PoseRadius kSameTrajectory{0.1, 1};

DepthAgreement agreementAt(const Eigen::Isometry3d& T_a_b, const View& a, const View& b) {
  return DepthComparison(DepthCalibration{}).compareBoth(b.depth, a.depth, T_a_b, kFineColumns);
}

double overlapOf(const DepthAgreement& seen, const DepthPicture& picture) {
  const int step = gridStep(picture, kFineColumns);
  const int pixels = gridPoints(picture.camera.width, step) * gridPoints(picture.camera.height, step);
  return (seen.agree + seen.contradict) / (2.0 * std::max(1, pixels));
}

bool agrees(const DepthAgreement& seen) {
  return seen.agree >= kLeastAgreement * (seen.agree + seen.contradict);
}

}  // namespace

PoseWithCovariance measured(const PlacedView& placed) {
  Matrix6d information = placed.information;
  information.diagonal().array() += 1 / (kUnknown * kUnknown);
  return {placed.T_a_b, withSharedErrors(symmetricInverse(information))};
}

std::optional<PlacedView> registered(const ViewPlacing& placing, const View& view, const View& other,
                                     const PoseWithCovariance& prior, bool search) {
  auto placed = placing.place(view, other, prior, search);
  if (placed && (placed->agreement < kLeastAgreement || placed->overlap < kLeastOverlap)) placed.reset();
  return placed;
}

bool isClear(const PlacedView& placed) {
  return placed.agreement >= kClearAgreement && placed.overlap >= kLoopOverlap;
}

bool depthAgrees(const Eigen::Isometry3d& T_a_b, const View& a, const View& b) {
  return agrees(agreementAt(T_a_b, a, b));
}

double overlapOf(const Eigen::Isometry3d& T_a_b, const View& a, const View& b) {
  return overlapOf(agreementAt(T_a_b, a, b), b.depth);
}

OverlapVerdict verdictOn(const Eigen::Isometry3d& T_a_b, const View& a, const View& b,
                         const Comparison& compared) {
  const DepthAgreement seen = agreementAt(T_a_b, a, b);
  if (overlapOf(seen, b.depth) < kLeastOverlap) return OverlapVerdict::says_nothing;
  const bool is_elsewhere = compared.placed && !compared.anywhere &&
                            !kSameTrajectory.joins(compared.placed->T_a_b, T_a_b) &&
                            squaredMahalanobis(measured(*compared.placed), T_a_b) > kFarEllipsoid;
  return agrees(seen) && !is_elsewhere ? OverlapVerdict::confirms : OverlapVerdict::contradicts;
}

}  // namespace facetloc::internal
