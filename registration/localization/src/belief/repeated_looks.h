// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "nearby/view_alignment.h"

#include <map>
#include <utility>

namespace facetloc::internal {

/** \brief Remembers which segments of the map a moving camera has been aligned with lately.
 *
 * An error of the map is the same in every view: a segment that is wrong must not pull the pose with it, view
 * by view. For a moving camera the error counts as one that is correlated from look to look with
 * rho = exp(-distance / kDistance - rotation / kRotation): for a pose that is measured again and again so,
 * each view has (1 - rho) / (1 + rho) of the information of a single one (the mean of a first-order
 * Gauss-Markov process), which is about one look for each kDistance, whatever the frame rate. */
class RepeatedLooks {
public:
  /** \brief The motion after which a look is as good as new: that between two local models [m, rad]. */
  static constexpr double kDistance = 0.5, kRotation = 15 * kDegree;

  /** \brief Enlarges Sigma_q of the segments that were looked at already. */
  void discount(LocalMap& surroundings) const;
  /** \brief A view was aligned with these. */
  void add(const std::vector<SegmentPair>& pairs, const LocalMap& surroundings);
  /** \brief The camera has moved on. */
  void move(const Eigen::Isometry3d& T_a_b);
  void clear() { correlation_.clear(); }

private:
  std::map<std::pair<int, int>, double> correlation_;  // with the last look at (local model, segment)
};

}  // namespace facetloc::internal
