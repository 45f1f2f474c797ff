// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include <vector>

namespace facetloc {

/** \brief Where the camera has been, as lines that may be drawn for hours: no more points than needed, and
 * coarser ones the longer it gets. */
class LiveTrajectory {
public:
  using Line = std::vector<Eigen::Vector3d>;

  /** \brief The camera is here now [m]. A new line begins after an interruption, and where it jumps; all
   * begins anew in another part of the map, whose frame has nothing to do with the one before. */
  void add(const Eigen::Vector3d& position, int part = 0);
  /** \brief Interrupts the line: the place of the camera is unknown. */
  void interrupt() { interrupted_ = true; }

  const std::vector<Line>& lines() const { return lines_; }

private:
  void thin();

  std::vector<Line> lines_;
  std::size_t points_ = 0;
  int part_ = 0;
  double spacing_ = 0.05;  // [m]
  bool interrupted_ = true;
};

}  // namespace facetloc
