// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>
#include <facetloc/features/so3.h>

#include <vector>

namespace facetloc {

/** \brief A floor near some place: normal . x = distance in the world [m], the normal upwards. */
struct FloorPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double distance = 0;
};

/** \brief The mean floor under a camera at these poses T_w_c, of which there is at least one. */
FloorPlane floorUnder(const std::vector<Eigen::Isometry3d>& T_w_c, const CameraMounting& mounting);

/** \brief Kalman update of a camera's pose by the floor that its robot stands on, which fixes what a bare
 * wall leaves open: roll, pitch and height.
 *
 * \param T_w_c the camera and its covariance
 * \param covariance of (roll, pitch, height) of the robot about that floor, 3x3, regular (floorCovariance())
 */
PoseWithCovariance updatedByFloor(const PoseWithCovariance& T_w_c, const CameraMounting& mounting,
                                  const FloorPlane& floor, const Eigen::Matrix3d& covariance);

}  // namespace facetloc
