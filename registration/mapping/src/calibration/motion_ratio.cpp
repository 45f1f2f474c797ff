// SPDX-License-Identifier: BSD-3-Clause
#include "base/median.h"
#include "calibration/pose_check.h"

#include <facetloc/features/pose.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace facetloc {
namespace {

constexpr double kCertain = 4;  // standard deviations

}  // namespace

bool MotionRatio::differs() const {
  return motions > 0 && (lowest > 1 + kCertain * std || highest < 1 - kCertain * std);
}

double MotionRatio::difference() const {
  if (!differs()) return 0;
  return lowest > 1 ? lowest - 1 : 1 / highest - 1;
}

double MotionRatio::certainAngleDeg() const { return angle_deg > kCertain * angle_std_deg ? angle_deg : 0; }

namespace internal {
namespace {

constexpr std::size_t kEnough = 5;
constexpr double kOutlier = 3;             // times the median residual
constexpr double kLeastCorrelation = 0.7;  // both sources of motion: else they measure different motions

struct Products {
  double images = 0, poses = 0, both = 0;
  Eigen::Vector3d across = Eigen::Vector3d::Zero();

  Products& operator+=(const Products& o) {
    images += o.images, poses += o.poses, both += o.both, across += o.across;
    return *this;
  }
  Products operator-(const Products& o) const {
    return {images - o.images, poses - o.poses, both - o.both, across - o.across};
  }
  Eigen::Vector3d turn() const { return across / both; }
  double lowest() const { return both / poses; }    // errors of the poses make it too small
  double highest() const { return images / both; }  // errors of the images make it too large
  double middle() const { return std::sqrt(images / poses); }
  bool isKnown() const { return both > kLeastCorrelation * std::sqrt(images * poses); }
};

Products productsOf(const MotionVectors& m) {
  return {m.by_images.squaredNorm(), m.by_poses.squaredNorm(), m.by_images.dot(m.by_poses),
          m.by_images.cross(m.by_poses)};
}

double medianRatio(const std::vector<MotionVectors>& motions) {
  std::vector<double> ratios;
  for (const MotionVectors& m : motions)
    if (const double n = m.by_poses.norm(); n > 0) ratios.push_back(m.by_images.norm() / n);
  return ratios.empty() ? 0 : median(std::move(ratios));
}

/** Leaves out motions far from the median's. */
void dropOutliers(std::vector<MotionVectors>& motions) {
  const double ratio = medianRatio(motions);
  const auto residual = [ratio](const MotionVectors& m) { return (m.by_images - ratio * m.by_poses).norm(); };
  std::vector<double> residuals;
  for (const MotionVectors& m : motions) residuals.push_back(residual(m));
  const double limit = kOutlier * median(std::move(residuals));
  motions.erase(std::remove_if(motions.begin(), motions.end(),
                               [&](const MotionVectors& m) { return residual(m) > limit; }),
                motions.end());
}

}  // namespace

MotionRatio motionRatio(std::vector<MotionVectors> motions) {
  MotionRatio found;
  if (motions.size() < kEnough) return found;
  dropOutliers(motions);
  std::map<double, Products> by_start;
  Products all;
  for (const MotionVectors& m : motions) by_start[m.start] += productsOf(m), all += productsOf(m);
  if (by_start.size() < kEnough || !all.isKnown()) return found;
  double squares = 0, turn_squares = 0;  // sums of the jackknife
  for (const auto& [start, of_start] : by_start) {
    const Products rest = all - of_start;
    if (!rest.isKnown()) return found;
    squares += std::pow(rest.middle() - all.middle(), 2);
    turn_squares += (rest.turn() - all.turn()).squaredNorm();
  }
  const auto n = static_cast<double>(by_start.size());
  found.motions = motions.size();
  found.ratio = all.middle(), found.lowest = all.lowest(), found.highest = all.highest();
  found.std = std::sqrt(squares * (n - 1) / n);
  found.angle_deg = std::atan(all.turn().norm()) / kDegree;
  found.angle_std_deg = std::sqrt(turn_squares * (n - 1) / n) / kDegree;
  return found;
}

}  // namespace internal
}  // namespace facetloc
