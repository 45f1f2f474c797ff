// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/registration/global_localization.h>
#include <facetloc/registration/likely_places.h>
#include <facetloc/registration/map_surroundings.h>
#include <facetloc/registration/repeated_looks.h>
#include <facetloc/registration/view_odometry.h>

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

/** \brief How a camera is tracked in a map. */
struct PoseTrackingParams {
  ViewOdometryParams odometry;
  int track_models = 5;             ///< nearest local models that a view is aligned with
  int dense_iterations = 4;         ///< of the alignment by all pixels
  double correlated_pixels = 200;   ///< so many depth pixels tell as much as one: neighbours err alike
  double significance = 2;          ///< least information of a direction that pixels may tell [their noise's]
  double correlated_views = 2;      ///< so many views tell as much as one: they see the same models alike
  double floor_length = 0.7;        ///< way after which a robot on wheels stands on other unevenness [m]
  double free_translation = 0.1;    ///< std from which on the pose cannot be told [m]: half the paper's 0.2 m
  double free_rotation_deg = 2.0;   ///< the same; the paper's 2 deg
  double lost_translation = 1.0;    ///< std at which nothing is left to track [m]: the paper's prior
  double lost_rotation_deg = 20.0;  ///< the same; the paper's prior
  double min_map_agreement = 0.6;   ///< share of the depth pixels that the map must confirm
  double min_map_pixels = 0.1;      ///< share of them that must be in the map to say so
  double sure_map_agreement = 0.85;  ///< the same of a place that is new, and of one that is beyond doubt
  int max_bad_views = 3;             ///< in a row at a place in doubt, until the camera is lost
  double patience = 1.0;             ///< with a map that contradicts while the camera's own views agree [s]
  double check_interval = 2.0;       ///< between searches of the whole map while a place is in doubt [s]
  double max_gap = 1.0;              ///< between two views; what comes later is a new start [s]
  double min_probability = 0.9;      ///< of a place, to begin to track there

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& field) {
    ViewOdometryParams::describe(p.odometry, field);
    field("track_models", p.track_models, 1, 100,
          "Number of nearest local models that a tracked view is aligned with.");
    field("track_dense_iterations", p.dense_iterations, 1, 100,
          "Gauss-Newton steps of the dense refinement of a tracked view.");
    field("track_correlated_pixels", p.correlated_pixels, 1.0, 1e6,
          "Number of depth pixels of a tracked view that together tell as much as one with independent "
          "errors.");
    field("track_significance", p.significance, 0.0, 1e6,
          "Information below which depth pixels leave a direction to the prior [that of the gradients' "
          "noise].");
    field("track_correlated_views", p.correlated_views, 1.0, 1e6,
          "Number of successive views that together tell as much as one with independent errors.");
    field("floor_length", p.floor_length, 1e-3, 1e6,
          "Way after which a robot on wheels (known camera mounting) stands on another piece of uneven floor "
          "[m].");
    field("free_translation", p.free_translation, 0.0, 100.0,
          "Position uncertainty from which on the pose cannot be told, standard deviation [m].");
    field("free_rotation_deg", p.free_rotation_deg, 0.0, 180.0,
          "Orientation uncertainty from which on the pose cannot be told, standard deviation [deg].");
    field("lost_translation", p.lost_translation, 0.0, 100.0,
          "Position uncertainty at which the camera is lost, standard deviation [m].");
    field("lost_rotation_deg", p.lost_rotation_deg, 0.0, 180.0,
          "Orientation uncertainty at which the camera is lost, standard deviation [deg].");
    field("min_map_agreement", p.min_map_agreement, 0.0, 1.0,
          "Share of a view's depth pixels that must agree with the map.");
    field("min_map_pixels", p.min_map_pixels, 0.0, 1.0,
          "Share of a view's depth pixels that the map must know to contradict it.");
    field("sure_map_agreement", p.sure_map_agreement, 0.0, 1.0,
          "Share of a view's depth pixels that must agree with the map at a new place, or it is in doubt.");
    field("max_bad_views", p.max_bad_views, 1, 1000,
          "Views in a row that disagree with a place in doubt until the camera is lost.");
    field("patience", p.patience, 0.0, 1e6,
          "Time that the map may contradict a camera that knows its motion until it is lost [s].");
    field("check_interval", p.check_interval, 0.0, 1e6,
          "Time between two searches of the whole map while the place is in doubt [s].");
    field("max_gap", p.max_gap, 1e-3, 1e6, "Longest time between two views of one track [s].");
    field("min_probability", p.min_probability, 0.0, 1.0,
          "Smallest probability of a place to begin to track there.");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief What tracking says of one view. */
struct TrackedPose {
  TrackingState state = TrackingState::searching;
  /** \brief In the world, with the covariance of a left, decoupled perturbation (so3.h); nothing while no
   * place is known. */
  std::optional<PoseWithCovariance> T_w_c;
  /** \brief The local model that shares most with the view: the pose relative to it and the pairs. */
  std::optional<Hypothesis> match;
  std::string reason;         ///< what is missing, in words; empty while localized or tracking
  double probability = 0;     ///< of the place where the track began
  double map_agreement = 0;   ///< share of the view's depth pixels that the map confirms
  double view_agreement = 0;  ///< the same of the camera's own key views
  bool searched = false;      ///< in the whole map, which takes its time
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
 * (alignView), and depth judges the outcome. Where the map knows the camera's mounting, a robot on wheels is
 * assumed, which stands on its floor. A place must be likely and be confirmed by the next view; one
 * that agrees only half with the map is compared with what the whole map says, now and then. A step takes
 * some milliseconds; a view that is searched in the whole map takes as long as global localization. Same
 * views and stamps, same answers. */
class PoseTracking {
public:
  /** \brief Throws std::invalid_argument for a parameter out of its range. */
  explicit PoseTracking(std::shared_ptr<const Map> map, const PoseTrackingParams& params = {},
                        const GlobalLocalizationParams& localization = {}, const SensorNoise& noise = {});

  /** \brief Takes the next view. Any view and any stamp [s] have an answer: an empty view, one that came too
   * late, and a stamp that goes back, which starts anew. */
  TrackedPose update(const View& view, double stamp);
  /** \brief Forgets the pose; the next view is searched in the whole map. */
  void relocalize();
  /** \brief Threads of global localization; 1 by default, 0 = all cores. */
  void setNumberOfThreads(int n) { localization_.setNumberOfThreads(n); }

private:
  struct Step;  // a view at its place in the map

  TrackedPose track(const View& view, const ViewMotion& motion);
  void stand(const Eigen::Isometry3d& motion);
  TrackedPose search(const View& view, const ViewMotion& motion);
  TrackedPose lose(const View& view, const ViewMotion& motion, const std::string& reason);
  TrackedPose answer(const View& view, const Step& step) const;
  void begin(const LikelyPlace& place);
  bool hasBetterPlace(const View& view, const Step& step);
  std::vector<LikelyPlace> placesOf(const View& view, std::string& reason) const;
  bool isSure(const Step& step) const;
  Step align(const View& view, const PoseWithCovariance& prior) const;

  PoseTrackingParams params_;
  GlobalLocalization localization_;
  MapSurroundings surroundings_;
  Eigen::Matrix3d floor_covariance_;  // of (roll, pitch, height)
  ViewAlignmentParams alignment_;
  DepthComparison comparison_;
  double inverse_depth_std_;
  ViewOdometry odometry_;
  RepeatedLooks looks_;
  PoseWithCovariance T_w_c_;
  std::vector<LikelyPlace> candidates_;  // of the last searches, none likely enough yet
  double stamp_ = 0;
  double probability_ = 0;
  double bad_since_ = 0, next_check_ = 0;  // [s]
  int bad_views_ = 0;
  bool active_ = false;     // there is a pose
  bool confirmed_ = false;  // and a second view has agreed with it
  bool doubtful_ = false;   // the camera has jumped; only a sure agreement with the map counts
  bool ever_ = false;       // there has been one
};

}  // namespace facetloc
