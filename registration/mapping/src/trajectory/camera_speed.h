// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include <deque>

namespace facetloc::internal {

/** \brief Image rhythm and speed of a camera, learned from its images so far. */
class CameraSpeed {
public:
  /** \brief Takes the time between two images [s]. */
  void addInterval(double dt);
  /** \brief Takes a motion that images have shown, and its duration [s]. */
  void addMotion(const Eigen::Isometry3d& T_before_after, double duration);

  /** \brief True for an interval that breaks the rhythm and takes the camera farther than consecutive images
   * can be expected to overlap. */
  bool isGap(double dt) const;
  /** \brief Upper bound of the distance that the camera covers in some time [m]. */
  double farthest(double duration) const;

private:
  std::deque<double> intervals_;  // latest ones
  double fastest_ = 0.25;         // [m/s]; slow walking pace until motions are known
  double fastest_turn_ = 0.25;    // [rad/s]
};

}  // namespace facetloc::internal
