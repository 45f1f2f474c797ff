// SPDX-License-Identifier: BSD-3-Clause
#include "motion/camera_motion.h"

#include "poses/pose_fusion.h"

#include <facetloc/features/pose.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace facetloc::internal {
namespace {

constexpr double kLongStep = 0.2;  // after which the next image may show another place [s]
// Least values of images that show the same; in quick succession it takes more to overrule the odometry.
constexpr double kLeastAgreement = 0.8, kLeastOverlap = 0.3;
constexpr double kClearAgreement = 0.9, kClearOverlap = 0.6;
constexpr double kGate = chiSquareQuantile(6, 0.999);
constexpr std::size_t kMostModes = 4;
constexpr double kMostDoubt = 4;  // that an odometry can raise: one step of fifty is wrong [nats]

// The probability that a camera which nothing has watched for a time is where no motion would have taken it:
// it was switched off, covered or carried.
double probabilityOfJump(double dt) {
  constexpr double kUsual = 1, kMeanTime = 5;  // interval of slow recordings, mean time until a jump [s]
  return 1 - std::exp(-std::max(0.0, dt - kUsual) / kMeanTime);
}

// A motion that the images alone show, so that it says how the camera moves.
bool isCertain(const Motion& motion) {
  constexpr double kProbable = 0.95, kLargestStd = 0.1;  // [m]
  return motion.source == Motion::Source::seen && motion.modes.front().probability >= kProbable &&
         largestTranslationStd(motion.likeliest().P) <= kLargestStd;
}

// The motion between two views, combined with the prior.
PoseWithCovariance withPrior(const PlacedView& placed, const PoseWithCovariance& prior) {
  const Matrix6d of_prior = symmetricInverse(prior.P);
  const Matrix6d P = symmetricInverse(placed.information + of_prior);
  return {boxplus(placed.T_a_b, P * of_prior * boxminus(prior.T, placed.T_a_b)), withSharedErrors(P)};
}

// Weighs the modes by another odometry, which is wrong now and then.
void weigh(const PoseWithCovariance& given, std::vector<MotionMode>& modes) {
  double sum = 0;
  for (MotionMode& mode : modes) {
    const double squared = squaredMahalanobis(mode.T_a_b, given);
    if (squared <= kGate) mode.T_a_b = fused(mode.T_a_b, given);
    sum += mode.probability *= std::exp(-std::min(kMostDoubt, 0.5 * squared));
  }
  for (MotionMode& mode : modes) mode.probability /= sum;
  std::stable_sort(modes.begin(), modes.end(),
                   [](const MotionMode& a, const MotionMode& b) { return a.probability > b.probability; });
}

}  // namespace

CameraMotion::CameraMotion(const ViewOdometryParams& params)
    : odometry_(params, alignmentWithCovariance(true)) {}

void CameraMotion::reset() {
  odometry_.reset();
  before_.reset();
  velocity_ = {};
}

// No modes if the two images do not show the same.
Motion CameraMotion::placed(const View& view, const PoseWithCovariance& prior, bool quick) const {
  Motion out;
  out.modes.clear();
  double sum = 0;
  for (const PlacedView& mode : placing_.modes(view, *before_, prior)) {
    if (mode.agreement < (quick ? kClearAgreement : kLeastAgreement) ||
        mode.overlap < (quick ? kClearOverlap : kLeastOverlap) || out.modes.size() == kMostModes)
      continue;
    if (out.modes.empty()) out.agreement = mode.agreement;
    out.modes.push_back({withPrior(mode, prior), std::exp(mode.log_likelihood)});
    sum += out.modes.back().probability;
  }
  for (MotionMode& mode : out.modes) mode.probability /= sum;
  out.source = Motion::Source::seen;
  return out;
}

Motion CameraMotion::next(const std::shared_ptr<const View>& view, double dt,
                          const std::optional<PoseWithCovariance>& given) {
  const ViewMotion film = odometry_.add(*view, dt);
  Motion out;
  out.modes.front().T_a_b = film.T_a_b;
  out.agreement = film.agreement;
  out.source = film.broken ? Motion::Source::broken : Motion::Source::seen;
  const bool shows_anything = !view->segments.empty() || !view->depth.empty();
  if (shows_anything && (dt > kLongStep || film.broken)) {
    const auto mounting = view->camera ? view->camera->mounting : std::nullopt;
    PoseWithCovariance prior = velocity_.next(dt, mounting);
    if (given)
      prior.T = given->T;
    else if (!film.broken && dt <= kLongStep)
      prior.T = film.T_a_b.T;
    Motion found;
    found.modes.clear();
    if (before_) found = placed(*view, prior, dt <= kLongStep);
    if (!found.modes.empty()) {
      if (!kSameMotion.joins(found.likeliest().T, film.T_a_b.T)) {
        odometry_.reset();
        odometry_.add(*view, 0);
      }
      out = std::move(found);
    } else if (dt > kLongStep) {
      out.modes.front().T_a_b = prior;
      out.source = given || !before_ ? Motion::Source::guessed : Motion::Source::broken;
    }
  }
  out.none = given ? 0 : probabilityOfJump(dt);
  if (isCertain(out))
    velocity_.add(out.likeliest().T, dt);
  else
    velocity_.interrupt();
  before_ = shows_anything ? view : nullptr;  // an older one would cover more than this motion
  if (!given) return out;
  // The wheels may be right, or somebody carries the robot: the views tell nothing.
  if (out.source == Motion::Source::broken) return Motion::known(*given);
  weigh(*given, out.modes);
  return out;
}

}  // namespace facetloc::internal
