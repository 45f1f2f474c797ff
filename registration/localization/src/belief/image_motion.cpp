// SPDX-License-Identifier: BSD-3-Clause
#include "belief/image_motion.h"

#include "motion/step_prior.h"
#include "shared/pose_fusion.h"
#include "shared/pose_radius.h"

#include <facetloc/features/chi_square.h>

#include <Eigen/Cholesky>

namespace facetloc::internal {
namespace {

constexpr double kLongStep = 0.2;  // after which the next image may show another place [s]
// Of two images that show the same; of two in quick succession it takes more to overrule the odometry.
constexpr double kLeastAgreement = 0.8, kLeastOverlap = 0.3;
constexpr double kClearAgreement = 0.9, kClearOverlap = 0.6;
constexpr double kGate = chiSquareQuantile(6, 0.999);

bool contradict(const PoseWithCovariance& a, const PoseWithCovariance& b) {
  return squaredMahalanobis(a, b) > kGate;
}

}  // namespace

ImageMotion::ImageMotion(const ViewOdometryParams& params)
    : odometry_(params, alignmentWithCovariance(), DepthComparison(DepthCalibration{})) {}

void ImageMotion::reset() {
  odometry_.reset();
  before_.reset();
}

std::optional<PoseWithCovariance> ImageMotion::placed(const View& view, const PoseWithCovariance& prior,
                                                      bool quick, double& agreement) const {
  const auto found = placing_.place(view, *before_, prior, true);
  if (!found || found->agreement < (quick ? kClearAgreement : kLeastAgreement) ||
      found->overlap < (quick ? kClearOverlap : kLeastOverlap))
    return {};
  agreement = found->agreement;
  return PoseWithCovariance{
      found->T_a_b, withSharedErrors(symmetricInverse(found->information + symmetricInverse(prior.P)))};
}

ViewMotion ImageMotion::add(const std::shared_ptr<const View>& view, double dt,
                            const std::optional<PoseWithCovariance>& given) {
  ViewMotion seen = odometry_.add(*view, dt);
  const bool shows_anything = !view->segments.empty() || !view->depth.empty();
  if (before_ && shows_anything && (dt > kLongStep || seen.broken)) {
    const auto mounting = view->camera ? view->camera->mounting : std::nullopt;
    PoseWithCovariance prior{Eigen::Isometry3d::Identity(), stepCovariance(mounting, true)};
    if (given)
      prior.T = given->T;
    else if (!seen.broken)
      prior.T = seen.T_a_b.T;
    double agreement = 0;
    if (const auto found = placed(*view, prior, dt <= kLongStep, agreement)) {
      if (!kSameMotion.joins(found->T, seen.T_a_b.T)) {
        odometry_.reset();
        odometry_.add(*view, 0);
      }
      seen = {*found, agreement, false};
    } else if (dt > kLongStep) {
      seen.T_a_b = {given ? given->T : Eigen::Isometry3d::Identity(), stepCovariance(mounting, true)};
      seen.broken = !given;
    }
  }
  if (shows_anything) before_ = view;
  if (!given) return seen;
  if (seen.broken)  // the wheels may be right, or somebody carries the robot: the views tell nothing
    return {*given, 0, false};
  if (!contradict(seen.T_a_b, *given)) seen.T_a_b = fused(seen.T_a_b, *given);
  return seen;
}

}  // namespace facetloc::internal
