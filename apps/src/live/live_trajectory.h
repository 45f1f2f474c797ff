// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include <utility>
#include <vector>

namespace facetloc {

/** \brief Where the camera has been, as lines that may be drawn for hours: no more points than needed, and
 * coarser ones the longer it gets. */
class LiveTrajectory {
public:
  using Line = std::vector<Eigen::Vector3d>;

  /** \brief The camera is here now [m]. A new line begins after an interruption, and where it jumps; all
   * begins anew in another part of the map, whose frame has nothing to do with the one before. */
  void add(const Eigen::Vector3d& position, int part = 0) {
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

  /** \brief Interrupts the line: the place of the camera is unknown. */
  void interrupt() { interrupted_ = true; }

  const std::vector<Line>& lines() const { return lines_; }

private:
  static constexpr double kJump = 1.0;  // [m] that no camera moves between two frames
  static constexpr std::size_t kMostPoints = 2000;

  /** Every other point of each line, and its last one. */
  void thin() {
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

  std::vector<Line> lines_;
  std::size_t points_ = 0;
  int part_ = 0;
  double spacing_ = 0.05;  // [m]
  bool interrupted_ = true;
};

}  // namespace facetloc
