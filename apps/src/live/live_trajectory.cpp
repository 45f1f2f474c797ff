// SPDX-License-Identifier: BSD-3-Clause
#include "live/live_trajectory.h"

namespace facetloc {
namespace {

constexpr double kJump = 1.0;  // [m] that no camera moves between two frames
constexpr std::size_t kMostPoints = 2000;

}  // namespace

void LiveTrajectory::add(const Eigen::Vector3d& position, int part) {
  if (part != part_) {
    *this = LiveTrajectory();
    part_ = part;
  }
  const bool jump = !lines_.empty() && (position - lines_.back().back()).norm() > kJump + spacing_;
  if (interrupted_ || jump) {
    lines_.push_back({position});
    interrupted_ = false;
  } else if ((position - lines_.back().back()).norm() >= spacing_) {
    lines_.back().push_back(position);
  } else {
    return;
  }
  if (++points_ > kMostPoints) thin();
}

/** Every other point of each line, and its last one. */
void LiveTrajectory::thin() {
  points_ = 0;
  spacing_ *= 2;
  for (Line& line : lines_) {
    Line kept;
    for (std::size_t i = 0; i < line.size(); i += 2) kept.push_back(line[i]);
    if (line.size() % 2 == 0) kept.push_back(line.back());
    line = std::move(kept);
    points_ += line.size();
  }
  if (2 * lines_.size() > kMostPoints) lines_.erase(lines_.begin(), lines_.begin() + kMostPoints / 4);
}

}  // namespace facetloc
