// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "belief/map_surroundings.h"
#include "nearby/view_alignment.h"

#include <facetloc/localization/localization_params.h>
#include <facetloc/registration/hypothesis.h>

#include <map>
#include <memory>
#include <utility>

namespace facetloc::internal {

/** \brief Remembers which segments of the map a moving camera has been aligned with lately.
 *
 * An error of the map is the same in every view: a segment that is wrong must not pull the pose with it, view
 * by view. For a moving camera the error counts as one that is correlated from observation to observation
 * with rho = exp(-distance / kDistance - rotation / kRotation): for a pose that is measured again and again
 * so, each view has (1 - rho) / (1 + rho) of the information of a single one (the mean of a first-order
 * Gauss-Markov process), which is about one observation for each kDistance, whatever the frame rate. */
class RepeatedObservations {
public:
  /** \brief The motion after which an observation is as good as new: that between two local models [m, rad].
   */
  static constexpr double kDistance = 0.5, kRotation = 15 * kDegree;

  /** \brief Enlarges Sigma_q of the segments that were looked at already. */
  void discount(LocalMap& surroundings) const;
  /** \brief A view was aligned with these. */
  void add(const std::vector<SegmentPair>& pairs, const LocalMap& surroundings);
  /** \brief The camera has moved on. */
  void move(const Eigen::Isometry3d& T_a_b);
  void clear() { correlation_.clear(); }

private:
  std::map<std::pair<int, int>, double> correlation_;  // with the last observation of (local model, segment)
};

/** \brief A view at a place of the map that was known before. */
struct FollowedPlace {
  ViewAlignment alignment;
  LocalMap surroundings;
  double agreement = 0;    ///< share of the depth pixels that the map confirms
  bool is_judged = false;  ///< the map knows enough of them to object

  bool isContradicted() const;
  bool isInDoubt() const;
};

/** \brief Follows a camera from view to view at a place that is known, between the observations of a belief:
 * by the planes and pixels of the local models around it, and a robot by its floor (METHOD 3.1 to 3.4). */
class PlaceFollowing {
public:
  PlaceFollowing(std::shared_ptr<const Map> map, const GlobalLocalizationParams& params);

  /** \brief The camera has moved on. */
  void move(const Eigen::Isometry3d& T_a_b) { observations_.move(T_a_b); }
  /** \brief Nothing has been looked at lately. */
  void clear() { observations_.clear(); }
  /** \brief A robot's pose, corrected by the floor that it stands on, as far as that is new by a motion.
   * The same pose for a camera that is not mounted as the map's. */
  PoseWithCovariance onFloor(const View& view, int part, const PoseWithCovariance& T_w_c,
                             const Eigen::Isometry3d& motion) const;
  /** \brief Aligns a view with the local models around a pose. \param part of the map */
  FollowedPlace at(const View& view, int part, const PoseWithCovariance& T_w_c) const;
  /** \brief The place is accepted: the segments it was aligned with count as observed. */
  void accept(const FollowedPlace& place) { observations_.add(place.alignment.pairs, place.surroundings); }
  /** \brief The local model that shares most with the view, with the pairs; nothing if none does. */
  std::optional<Hypothesis> match(const FollowedPlace& place, int part) const;

private:
  MapSurroundings surroundings_;
  Eigen::Matrix3d floor_covariance_;  // covariance of (roll, pitch, height)
  ViewAlignmentParams alignment_;
  DepthComparison comparison_;
  RepeatedObservations observations_;
};

}  // namespace facetloc::internal
