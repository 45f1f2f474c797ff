// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

namespace facetloc::internal {

/** \brief Orientation of the optical axes (x right, y down, z forward) of a level camera that looks along x,
 * in the axes of a robot (x forward, y left, z up). */
inline Eigen::Matrix3d opticalInBase() {
  return (Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished();
}
/** \brief The same in axes with y up and z backward, as of ARKit and Blender. */
inline Eigen::Matrix3d opticalInOpenGl() { return Eigen::Vector3d(1, -1, -1).asDiagonal(); }

/** \brief A pose that was read as of the camera in the world, its quaternion in the order x y z w, as meant.
 * \param w_first its quaternion is in the order w x y z \param inverse it is of the world in the camera */
inline Eigen::Isometry3d poseAsMeant(bool w_first, bool inverse, Eigen::Isometry3d T) {
  if (w_first) {
    const Eigen::Quaterniond q(T.linear());
    T.linear() = Eigen::Quaterniond(q.x(), q.y(), q.z(), q.w()).normalized().toRotationMatrix();
  }
  return inverse ? T.inverse() : T;
}

}  // namespace facetloc::internal
