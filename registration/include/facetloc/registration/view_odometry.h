// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>
#include <facetloc/registration/view_alignment.h>

#include <deque>
#include <optional>

namespace facetloc {

/** \brief How a camera moves from view to view, and which of its views are kept. */
struct ViewOdometryParams {
  double speed_change = 0.4;         ///< from one view to the next, along each axis [m/s]
  double turn_rate_change_deg = 40;  ///< the same, about each axis [deg/s]
  double slip_speed = 0.01;          ///< of a robot on wheels, sideways and up and down [m/s]
  double tilt_rate_deg = 10;         ///< roll and pitch of a robot on wheels [deg/s]
  double key_distance = 0.3;         ///< from every key view, at which a new one is taken [m]
  double key_rotation_deg = 12;      ///< the same
  int keys = 2;                      ///< nearest key views that a view is aligned with
  int kept_keys = 20;                ///< the latest so many are kept
  double min_view_agreement = 0.7;   ///< share of the depth pixels that the key views must confirm

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& field) {
    field("speed_change", p.speed_change, 1e-3, 100.0,
          "Change of the velocity from view to view along each axis, standard deviation [m/s].");
    field("turn_rate_change_deg", p.turn_rate_change_deg, 0.1, 3600.0,
          "Change of the turn rate from view to view about each axis, standard deviation [deg/s].");
    field("slip_speed", p.slip_speed, 1e-3, 100.0,
          "Speed sideways, up and down of a robot on wheels (known camera mounting), standard deviation "
          "[m/s].");
    field("tilt_rate_deg", p.tilt_rate_deg, 0.1, 3600.0,
          "Rate of roll and pitch of a robot on wheels (known camera mounting), standard deviation [deg/s].");
    field("key_distance", p.key_distance, 0.0, 100.0,
          "Distance from all key views at which a new one is taken [m].");
    field("key_rotation_deg", p.key_rotation_deg, 0.0, 180.0,
          "Rotation from all key views at which a new one is taken [deg].");
    field("key_views", p.keys, 1, 100, "Number of nearest key views that a view is aligned with.");
    field("kept_key_views", p.kept_keys, 1, 10000, "Number of latest key views that are kept.");
    field("min_view_agreement", p.min_view_agreement, 0.0, 1.0,
          "Share of a view's depth pixels that must agree with the key views.");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief A motion between two views. */
struct ViewMotion {
  /// of the camera: a = the view before, b = this view; the covariance is what the step adds to an error of
  /// the pose, not that of this pair of views alone: errors against a key view last as long as it does
  PoseWithCovariance T_a_b;
  double agreement = 0;  ///< share of the view's depth pixels that the key views confirm; 0 if unknown
  bool broken = false;   ///< the view contradicts the key views: nobody knows how the camera moved
};

/** \brief Tells from its own latest views how a camera moves. It knows no map: its world is where it began.
 *
 * Each view is aligned with the nearest of some key views, so that the pose does not drift while the camera
 * looks at the same things. The prior is the last velocity. A robot on wheels stays on its floor and does not
 * slip sideways, unless its views have seen it do so: that carries it past a bare wall. */
class ViewOdometry {
public:
  /** \param mounting of the camera on a robot on wheels; without it the camera moves as it likes */
  ViewOdometry(const ViewOdometryParams& params, const ViewAlignmentParams& alignment,
               const DepthComparison& comparison, double inverse_depth_std,
               const std::optional<CameraMounting>& mounting = {});

  /** \brief Forgets all views. */
  void reset();
  /** \brief Takes the next view, dt >= 0 [s] after the last one. The first view has not moved. A view that
   * breaks the chain begins a new one. */
  ViewMotion add(const View& view, double dt);

private:
  struct Slide {  // of a robot on wheels, to the left [m/s]
    double speed = 0, variance = 0;
  };
  struct Key {
    View view;
    Eigen::Isometry3d T_o_k;
  };
  PoseWithCovariance predict(double dt) const;
  Surroundings around(const Eigen::Isometry3d& T_o_c) const;
  void learnVelocity(const PoseWithCovariance& predicted, const PoseWithCovariance& found, double dt);
  Matrix6d errorOfStep(const Matrix6d& predicted, const PoseWithCovariance& T_o_c) const;
  bool slides() const;
  void rollOn(PoseWithCovariance& T_o_c, double dt);
  void takeKey(const View& view);

  ViewOdometryParams params_;
  ViewAlignmentParams alignment_;
  DepthComparison comparison_;
  double inverse_depth_std_;
  std::optional<Matrix6d> camera_motion_;  // by that of a robot on wheels
  std::deque<Key> keys_;
  Eigen::Isometry3d T_o_c_ = Eigen::Isometry3d::Identity();
  Slide slide_;
  Vector6d velocity_ = Vector6d::Zero();  // in the axes of the last camera [rad/s, m/s]
};

}  // namespace facetloc
