// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "nearby/view_alignment.h"

#include <facetloc/registration/registration_params.h>

#include <deque>
#include <optional>

namespace facetloc::internal {

/** \brief Change of the velocity of a camera, in the hand or on a robot, from view to view along each axis,
 * standard deviation [m/s]. */
constexpr double kSpeedChange = 0.4;
/** \brief Change of its turn rate about each axis, standard deviation [deg/s]. */
constexpr double kTurnRateChangeDeg = 40;

/** \brief A motion between two views. */
struct ViewMotion {
  /// pose of the camera: a = the view before, b = this view; the covariance is the growth of the error of
  /// the pose, not the error of this pair of views alone: errors against a keyframe last as long as it does
  PoseWithCovariance T_a_b;
  double agreement = 0;  ///< share of the view's depth pixels that the keyframes confirm; 0 if unknown
  bool broken = false;   ///< the view contradicts the keyframes: the motion of the camera is unknown
};

/** \brief Tells from its own latest views how a camera moves. It knows no map: its world is where it began.
 *
 * Each view is aligned with the nearest of some keyframes, so that the pose does not drift while the camera
 * looks at the same things. The prior is the last velocity. A robot on wheels, known from the mounting of a
 * view's camera, stays on its floor and does not slip sideways, unless its views have seen it do so: that
 * carries it past a bare wall. Any other camera moves as it likes. */
class ViewOdometry {
public:
  ViewOdometry(const ViewOdometryParams& params, const ViewAlignmentParams& alignment)
      : params_(params), alignment_(alignment) {}

  /** \brief Forgets all views. */
  void reset();
  /** \brief Takes the next view, dt >= 0 [s] after the last one. The first view has not moved. A view that
   * breaks the chain begins a new one. */
  ViewMotion add(const View& view, double dt);

private:
  struct SideSlip {  // side slip of a robot on wheels, to the left [m/s]
    double speed = 0, variance = 0;
  };
  struct Key {
    View view;
    Eigen::Isometry3d T_o_k;
  };
  PoseWithCovariance predict(double dt) const;
  LocalMap around(const Eigen::Isometry3d& T_o_c) const;
  PoseWithCovariance aligned(const View& view, const LocalMap& around_us,
                             const PoseWithCovariance& predicted) const;
  void learnVelocity(const PoseWithCovariance& predicted, const PoseWithCovariance& found, double dt);
  Matrix6d errorOfStep(const Matrix6d& predicted, const PoseWithCovariance& T_o_c) const;
  bool slips() const;
  void applyNonholonomic(PoseWithCovariance& T_o_c, double dt);
  void takeKey(const View& view);

  ViewOdometryParams params_;
  ViewAlignmentParams alignment_;
  DepthComparison comparison_{DepthCalibration{}};
  std::optional<Matrix6d> camera_motion_;  // motion of the latest camera per motion of its robot on wheels
  Matrix6d jolt_ = Matrix6d::Zero();       // covariance of it on another piece of uneven floor
  std::deque<Key> keys_;
  Eigen::Isometry3d T_o_c_ = Eigen::Isometry3d::Identity();
  SideSlip side_slip_;
  Vector6d velocity_ = Vector6d::Zero();  // velocity in the axes of the last camera [rad/s, m/s]
};

}  // namespace facetloc::internal
