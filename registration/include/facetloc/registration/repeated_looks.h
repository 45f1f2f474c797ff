// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/registration/view_alignment.h>

#include <map>
#include <utility>

namespace facetloc {

/** \brief Remembers which segments of the map a moving camera has been aligned with lately.
 *
 * An error of the map is the same in every view: n looks at a segment measure a pose with the covariance
 * Sigma_map + Sigma_view / n, not with the n-th part of their sum. With two segments of about the same
 * covariance the n-th look so adds 1 / (n (n + 1)) of what an exact one would tell, and that is what it tells
 * if Sigma_map is taken n (n + 1) - 1 times as large. As the camera moves on, the errors of its motion make a
 * look a new one again. */
class RepeatedLooks {
public:
  /** \brief The motion after which a look is new again: that between two local models [m, rad]. */
  static constexpr double kDistance = 0.5, kRotation = 15 * kDegree;

  /** \brief Enlarges Sigma_q of the segments that were looked at already. */
  void discount(Surroundings& surroundings) const;
  /** \brief A view was aligned with these. */
  void add(const std::vector<SegmentPair>& pairs, const Surroundings& surroundings);
  /** \brief The camera has moved on. */
  void move(const Eigen::Isometry3d& T_a_b);
  void clear() { looks_.clear(); }

private:
  std::map<std::pair<int, int>, double> looks_;  // at segments (local model, segment)
};

}  // namespace facetloc
