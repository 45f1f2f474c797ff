// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>
#include <facetloc/features/pose.h>

#include <Eigen/Core>

#include <optional>

namespace facetloc::internal {

/** \brief Covariance of where a camera is one image later, about where it is thought to be, if nothing else
 * tells: in the hand any motion within arm's reach; on a robot on wheels along its floor and, unless it has
 * been seen to slip, hardly sideways. */
Matrix6d stepCovariance(const std::optional<CameraMounting>& mounting, bool slips);

/** \brief Covariance of the motion of a camera in some time [s] about no motion, if nothing else tells: as
 * far as one that is carried, or on a robot, moves at a walk. */
Matrix6d motionPrior(double dt, const std::optional<CameraMounting>& mounting);

/** \brief How far sideways a motion of its camera takes a robot [m], and the variance of that. */
struct SidewaysShift {
  double shift = 0, variance = 0;
};
SidewaysShift sidewaysShift(const PoseWithCovariance& T_before_after, const CameraMounting& mounting);

/** \brief Standard deviation of how far a robot that does not slip gets sideways from image to image [m]. */
constexpr double kSidewaysStd = 0.05;

/** \brief Prior of the next motion of a camera, about the share w of its latest velocity that it has been
 * seen to keep from motion to motion (METHOD 12.2): least squares of v_t = w v_(t-1) over its own certain
 * motions, beside a few of a camera that starts and stops at will. */
class VelocityPrior {
public:
  /** \brief A motion T_a_b that took dt [s] and is certain. */
  void add(const Eigen::Isometry3d& T_a_b, double dt);
  /** \brief The camera was not watched: its velocity is unknown, its habits are not. */
  void interrupt() { velocity_.reset(); }
  /** \brief T_a_b over the next dt [s]. */
  PoseWithCovariance next(double dt, const std::optional<CameraMounting>& mounting) const;
  /** \brief w, from 0 to 1. */
  double keptShare() const;

private:
  std::optional<Eigen::Vector3d> velocity_;  // camera axes now [m/s]
  double product_ = 0, square_ = 0;          // sums of v_t . v_(t-1) and |v_(t-1)|^2
};

}  // namespace facetloc::internal
