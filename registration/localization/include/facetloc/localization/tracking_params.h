// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/params.h>

namespace facetloc {

/** \brief How a camera moves from view to view, and which of its views are kept as keyframes. */
struct ViewOdometryParams {
  static constexpr const char* kTitle = "Motion of the camera from view to view";
  double speed_change = 0.4;         ///< from one view to the next, along each axis [m/s]
  double turn_rate_change_deg = 40;  ///< the same, about each axis [deg/s]
  double slip_speed = 0.01;          ///< of a robot on wheels, sideways and up and down [m/s]
  double tilt_rate_deg = 10;         ///< roll and pitch of a robot on wheels [deg/s]
  double key_distance = 0.3;         ///< from every keyframe, at which a new one is taken [m]
  double key_rotation_deg = 12;      ///< the same
  int keys = 2;                      ///< nearest keyframes that a view is aligned with
  int kept_keys = 20;                ///< the latest so many are kept
  double min_agreement = 0.7;        ///< share of the depth pixels that the keyframes must confirm

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("speed_change", p.speed_change, 1e-3, 100.0,
          "Change of the velocity from view to view along each axis, standard deviation [m/s].");
    visit("turn_rate_change_deg", p.turn_rate_change_deg, 0.1, 3600.0,
          "Change of the turn rate from view to view about each axis, standard deviation [deg/s].");
    visit("slip_speed", p.slip_speed, 1e-3, 100.0,
          "Speed sideways and up and down of a robot on wheels, standard deviation [m/s].");
    visit("tilt_rate_deg", p.tilt_rate_deg, 0.1, 3600.0,
          "Rate of roll and pitch of a robot on wheels, standard deviation [deg/s].");
    visit("key_distance", p.key_distance, 0.0, 100.0,
          "Distance from all keyframes at which a new one is taken [m].");
    visit("key_rotation_deg", p.key_rotation_deg, 0.0, 180.0,
          "Rotation from all keyframes at which a new one is taken [deg].");
    visit("keys", p.keys, 1, 100, "Number of nearest keyframes that a view is aligned with.");
    visit("kept_keys", p.kept_keys, 1, 10000, "Number of latest keyframes that are kept.");
    visit("min_agreement", p.min_agreement, 0.0, 1.0,
          "Share of a view's depth pixels that must agree with the keyframes, or its motion is unknown.");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief When the pose of a tracked camera is unknown, and when the camera is lost. */
struct PoseTrackingParams {
  static constexpr const char* kTitle = "Tracking of a camera in a map";
  ViewOdometryParams odometry;
  int models = 5;                   ///< nearest local models that a view is aligned with
  int dense_iterations = 4;         ///< of the alignment by all pixels
  double correlated_pixels = 200;   ///< so many depth pixels tell as much as one: neighbours err alike
  double significance = 2;          ///< least information of a direction that pixels may tell [their noise's]
  double correlated_views = 2;      ///< so many views tell as much as one: they see the same models alike
  double floor_length = 0.7;        ///< way after which a robot on wheels stands on other unevenness [m]
  double free_translation = 0.1;    ///< std from which on the pose is unknown [m]: half the paper's 0.2 m
  double free_rotation_deg = 2.0;   ///< the same; the paper's 2 deg
  double lost_translation = 1.0;    ///< std at which nothing is left to track [m]: the paper's prior
  double lost_rotation_deg = 20.0;  ///< the same; the paper's prior
  double min_agreement = 0.6;       ///< share of the depth pixels that the map must confirm
  double min_known_pixels = 0.1;    ///< share of them that must be in the map to say so
  double sure_agreement = 0.85;     ///< agreement of a place that is new, and of one that is beyond doubt
  int max_bad_views = 3;            ///< in a row at a place in doubt, until the camera is lost
  double patience = 1.0;            ///< with a map that contradicts while the camera's own views agree [s]
  double check_interval = 2.0;      ///< between searches of the whole map while a place is in doubt [s]
  double max_gap = 1.0;             ///< between two views; what comes later is a new start [s]
  double odometry_drift = 0.02;     ///< of a given odometry: error of the way, as a share of it
  double odometry_turn_deg = 1;     ///< of a given odometry: error of the heading after 1 m of way
  double min_probability = 0.9;     ///< of a place, to begin to track there

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("odometry", p.odometry);
    visit("models", p.models, 1, 100, "Number of nearest local models that a tracked view is aligned with.");
    visit("dense_iterations", p.dense_iterations, 1, 100,
          "Largest number of Gauss-Newton steps of the alignment of a tracked view by all depth pixels.");
    visit("correlated_pixels", p.correlated_pixels, 1.0, 1e6,
          "Number of depth pixels that together tell as much as one with an independent error.");
    visit("significance", p.significance, 0.0, 1e6,
          "Information below which depth pixels leave a direction to the prior [in terms of the gradients' "
          "noise].");
    visit("correlated_views", p.correlated_views, 1.0, 1e6,
          "Number of successive views that together tell as much as one with an independent error.");
    visit("floor_length", p.floor_length, 1e-3, 1e6,
          "Way after which a robot on wheels stands on another piece of uneven floor [m].");
    visit("free_translation", p.free_translation, 0.0, 100.0,
          "Position uncertainty from which on the pose is unknown, standard deviation [m].");
    visit("free_rotation_deg", p.free_rotation_deg, 0.0, 180.0,
          "Orientation uncertainty from which on the pose is unknown, standard deviation [deg].");
    visit("lost_translation", p.lost_translation, 0.0, 100.0,
          "Position uncertainty at which the camera is lost, standard deviation [m].");
    visit("lost_rotation_deg", p.lost_rotation_deg, 0.0, 180.0,
          "Orientation uncertainty at which the camera is lost, standard deviation [deg].");
    visit("min_agreement", p.min_agreement, 0.0, 1.0,
          "Share of a view's depth pixels that must agree with the map, or the place is contradicted.");
    visit("min_known_pixels", p.min_known_pixels, 0.0, 1.0,
          "Share of a view's depth pixels that the map must know to contradict a place.");
    visit("sure_agreement", p.sure_agreement, 0.0, 1.0,
          "Share of a view's depth pixels that must agree with the map at a new place, or it is in doubt.");
    visit("max_bad_views", p.max_bad_views, 1, 1000,
          "Number of views in a row that disagree with a place in doubt until the camera is lost.");
    visit("patience", p.patience, 0.0, 1e6,
          "Time that the map may contradict a camera that knows its motion until it is lost [s].");
    visit("check_interval", p.check_interval, 0.0, 1e6,
          "Time between two searches of the whole map while the place is in doubt [s].");
    visit("max_gap", p.max_gap, 1e-3, 1e6, "Longest time between two views of one track [s].");
    visit("odometry_drift", p.odometry_drift, 0.0, 1.0,
          "Error of a given odometry along its way, standard deviation as a share of the way.");
    visit("odometry_turn_deg", p.odometry_turn_deg, 0.0, 180.0,
          "Error of the heading of a given odometry after one metre of way, standard deviation [deg].");
    visit("min_probability", p.min_probability, 0.0, 1.0,
          "Smallest probability of a place at which tracking begins there.");
  }
  void validate() const { checkRanges(*this); }
};

}  // namespace facetloc
