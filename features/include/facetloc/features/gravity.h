// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/pose.h>

#include <Eigen/Core>

namespace facetloc {

/** \brief Direction of gravity as a sensor has measured it: downwards, in the camera's optical frame (x
 * right, y down, z forward). An accelerometer at rest measures the opposite direction. */
struct Gravity {
  Eigen::Vector3d down = Eigen::Vector3d::UnitY();  ///< unit vector
  double std = kDegree;  ///< standard deviation about each of two horizontal axes [rad]

  /** \brief A finite unit vector, and a standard deviation from 0.001 to 90 deg? */
  bool valid() const;
};

/** \brief Gravity of a vector of any length. Throws std::invalid_argument, with a sentence, for a vector
 * without a direction and for an impossible standard deviation. \param std [rad] */
Gravity gravityAlong(const Eigen::Vector3d& vector, double std);

/** \brief Rotation from a camera's axes into level ones with the same heading: y is downwards, and z the
 * horizontal direction of the optical axis; of a camera that looks straight down or up, the horizontal
 * direction of its upper or lower edge. \param down unit vector in the camera's axes */
Eigen::Matrix3d levelling(const Eigen::Vector3d& down);

}  // namespace facetloc
