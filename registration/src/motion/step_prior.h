// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>
#include <facetloc/features/pose.h>

#include <optional>

namespace facetloc::internal {

/** \brief Covariance of where a camera is one image later, about where it is thought to be, if nothing else
 * tells: in the hand any way within arm's reach; on a robot on wheels along its floor and, unless it has been
 * seen to slip, hardly sideways. */
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

}  // namespace facetloc::internal
