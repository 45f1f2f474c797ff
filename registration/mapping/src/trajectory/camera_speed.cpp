// SPDX-License-Identifier: BSD-3-Clause
#include "trajectory/camera_speed.h"

#include <facetloc/features/pose.h>

#include <algorithm>
#include <vector>

namespace facetloc::internal {
namespace {

constexpr std::size_t kLatest = 100;                             // intervals that make the rhythm
constexpr double kUsual = 0.9;                                   // share of them that are no gaps
constexpr double kRhythm = 2;                                    // usual intervals that a gap is longer than
constexpr double kShortest = 0.1;                                // duration that tells a speed from noise [s]
constexpr double kExpected = 0.8, kExpectedTurn = 40 * kDegree;  // two standard deviations of a step [m]
constexpr double kWalking = 1.5, kSurge = 2;  // speed of any camera [m/s], and factor beyond the fastest seen

}  // namespace

void CameraSpeed::addInterval(double dt) {
  intervals_.push_back(dt);
  if (intervals_.size() > kLatest) intervals_.pop_front();
}

void CameraSpeed::addMotion(const Eigen::Isometry3d& T_before_after, double duration) {
  if (duration < kShortest) return;
  fastest_ = std::max(fastest_, T_before_after.translation().norm() / duration);
  fastest_turn_ = std::max(fastest_turn_, rotationAngle(T_before_after.linear()) / duration);
}

bool CameraSpeed::isGap(double dt) const {
  if (intervals_.empty()) return false;
  std::vector<double> intervals(intervals_.begin(), intervals_.end());
  const auto rhythm = intervals.begin() + static_cast<std::ptrdiff_t>(kUsual * double(intervals.size() - 1));
  std::nth_element(intervals.begin(), rhythm, intervals.end());
  if (dt <= kRhythm * *rhythm) return false;
  return fastest_ * dt > kExpected || fastest_turn_ * dt > kExpectedTurn;
}

double CameraSpeed::farthest(double duration) const {
  return std::max(kWalking, kSurge * fastest_) * duration;
}

}  // namespace facetloc::internal
