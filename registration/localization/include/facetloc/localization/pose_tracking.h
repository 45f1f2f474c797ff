// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>
#include <facetloc/localization/localization_params.h>
#include <facetloc/localization/tracking_params.h>
#include <facetloc/registration/hypothesis.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace facetloc {

/** \brief What is known of the camera's pose. */
enum class TrackingState {
  searching,    ///< no place has been found since the start
  localized,    ///< global localization has found the place and the next view has confirmed it
  tracking,     ///< the pose follows from the one before
  cannot_tell,  ///< so it does, but the view does not fix it; the reason tells which directions are free
  lost          ///< the view contradicts the pose; a place is being searched
};

/** \brief "searching", "localized", "tracking", "cannot tell", "lost". */
const char* stateName(TrackingState state);

/** \brief A place where the camera may be. */
struct PossiblePlace {
  PoseWithCovariance T_w_c;
  int part = 0;            ///< of the map, in whose frame the pose is
  double probability = 0;  ///< beside the others, and that the map does not hold the place
};

/** \brief What tracking says of one view. */
struct TrackedPose {
  TrackingState state = TrackingState::searching;
  /** \brief In the world, or in the frame of another part of the map, with the covariance of a left,
   * decoupled perturbation (pose.h); nothing while no place is known. */
  std::optional<PoseWithCovariance> T_w_c;
  int part = 0;  ///< of the map, in whose frame the pose is
  /** \brief The local model that shares most with the view: the pose relative to it and the pairs. */
  std::optional<Hypothesis> match;
  std::string reason;         ///< what is missing, in words; empty while localized or tracking
  double probability = 0;     ///< of the place where the track began
  double map_agreement = 0;   ///< share of the view's depth pixels that the map confirms
  double view_agreement = 0;  ///< share of them that the camera's own key views confirm
  bool searched = false;      ///< in the whole map, which takes its time
  /** \brief Where the camera may be while no place is known, most probable first, by all views since then. */
  std::vector<PossiblePlace> places;
};

/** \brief Follows a camera through a map from view to view, by registration with the last pose and a motion
 * covariance as the prior (the paper's reference [14]), and finds it again by global localization.
 *
 *     facetloc::PoseTracking tracking(map);
 *     for (...) {
 *       const facetloc::TrackedPose pose = tracking.update(view, stamp);
 *       show(stateName(pose.state), pose.T_w_c, pose.reason);
 *     }
 *
 * The camera's own views tell how it has moved (ViewOdometry), the nearest local models where it is
 * (alignView), and depth judges the outcome. A camera whose mounting is known is on a robot on wheels, which
 * stands on the map's floor if the map's camera is mounted alike. A place must be likely and be confirmed by
 * the next view; one that agrees only half with the map is compared with what the whole map says, now and
 * then. A step takes some milliseconds; a view that is searched in the whole map takes as long as global
 * localization. Same views and stamps, same answers. */
class PoseTracking {
public:
  /** \brief Throws std::invalid_argument for a parameter out of its range. */
  explicit PoseTracking(std::shared_ptr<const Map> map, const PoseTrackingParams& params = {},
                        const GlobalLocalizationParams& localization = {});
  PoseTracking(PoseTracking&&) noexcept;
  PoseTracking& operator=(PoseTracking&&) noexcept;
  ~PoseTracking();

  /** \brief Takes the next view. Any view and any stamp [s] have an answer: an empty view, one that came too
   * late, and a stamp that goes back, which starts anew. */
  TrackedPose update(const View& view, double stamp) { return update(view, stamp, {}); }
  /** \brief The same where an odometry tells how the camera has moved since the view before, T_before_now:
   * that carries it past what shows nothing, and over gaps of any length. The parameters say its
   * error. */
  TrackedPose update(const View& view, double stamp, const std::optional<Eigen::Isometry3d>& motion);
  /** \brief Forgets the pose; the next view is searched in the whole map. */
  void relocalize();
  /** \brief Threads of global localization; 1 by default, 0 = all cores. */
  void setNumberOfThreads(int n);

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace facetloc
