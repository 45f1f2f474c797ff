// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "evaluation/alignment.h"
#include "evaluation/sample.h"

#include <facetloc/io/trajectory.h>

#include <cstddef>
#include <string>
#include <vector>

namespace facetloc {

constexpr const char *kOverSecond = "1 s", *kOverMetre = "1 m", *kOverTenth = "10 % of the way";

/** \brief Errors of the motion from one pose to a later one. */
struct RelativeErrors {
  std::string over;           ///< kOverSecond, kOverMetre or kOverTenth
  std::size_t intervals = 0;  ///< one begins at every pose that has another so far on, and not twice as far
  double mean_distance = 0;   ///< mean distance of the intervals [m]
  Sample translation;         ///< [m]
  Sample rotation_deg;

  /** \brief The mean error of the translation as a share of the distance, and of the rotation in deg/m; zero
   * where the camera stands still. */
  double translationShare() const { return mean_distance > 0 ? translation.mean / mean_distance : 0; }
  double rotationPerMetre() const { return mean_distance > 0 ? rotation_deg.mean / mean_distance : 0; }
};

/** \brief How wrong a trajectory is (Sturm, Engelhard, Endres, Burgard, Cremers, A Benchmark for the
 * Evaluation of RGB-D SLAM Systems, 2012). */
struct TrajectoryErrors {
  std::vector<PosePair> pairs;       ///< sorted by stamp, the estimated poses aligned
  std::vector<double> distance;      ///< true distance up to each pair [m]
  std::vector<double> translation;   ///< absolute error of each pair after alignment [m]
  std::vector<double> rotation_deg;  ///< error of the orientation at each stamp
  Alignment alignment;               ///< alignment of all pairs
  std::size_t without_truth = 0;     ///< estimated poses
  Sample absolute;                   ///< position errors [m]; its rmse is the absolute trajectory error
  Sample absolute_rotation_deg;
  std::vector<RelativeErrors> relative;  ///< those over a distance only if there is one

  double length() const { return distance.empty() ? 0 : distance.back(); }  ///< [m]
  double duration() const { return pairs.empty() ? 0 : pairs.back().stamp - pairs.front().stamp; }
  /** \brief The absolute trajectory error as a share of the distance; zero where the camera stands still. */
  double share() const { return length() > 0 ? absolute.rmse / length() : 0; }
};

/** \brief Compares each estimated pose with the true one nearest in time, if it lies within the tolerance
 * [s]. Throws std::invalid_argument if less than three have one, or if two poses of either have the same
 * stamp. */
TrajectoryErrors trajectoryErrors(const Trajectory& estimate, const Trajectory& truth,
                                  double tolerance = 0.02);

}  // namespace facetloc
