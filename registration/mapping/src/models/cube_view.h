// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/features/pose.h>
#include <facetloc/mapping/surface.h>

#include <limits>

namespace facetloc::internal {

/** \brief A camera that looks along a direction. */
inline Eigen::Isometry3d lookingAlong(const Eigen::Vector3d& from, const Eigen::Vector3d& direction) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = rotationBetween(Eigen::Vector3d::UnitZ(), direction);
  T.translation() = from;
  return T;
}

/** \brief All around a position: calls a function with the pose T_f_c and the image of each face of a cube of
 * side x side pixels. \param T_w_f pose of the position's frame in the surface's */
template <class Take>
void lookAround(const Surface& surface, const Eigen::Isometry3d& T_w_f, const Eigen::Vector3d& position,
                int side, Take&& take) {
  const double half = side / 2.0;
  const Intrinsics face{side, side, half, half, half - 0.5, half - 0.5};
  for (const int axis : {0, 1, 2})
    for (const double sign : {-1.0, 1.0}) {
      const Eigen::Isometry3d T_f_c = lookingAlong(position, sign * Eigen::Vector3d::Unit(axis));
      take(T_f_c, surface.render(face, T_w_f * T_f_c));
    }
}

/** \brief Distance to a surface along a unit vector [m]; infinite where nothing is met. \param T_w_f pose of
 * the frame of both in the surface's */
inline double distanceAlong(const Surface& surface, const Eigen::Vector3d& from,
                            const Eigen::Vector3d& direction,
                            const Eigen::Isometry3d& T_w_f = Eigen::Isometry3d::Identity()) {
  constexpr Intrinsics kRay{1, 1, 1, 1, 0, 0};
  const float z = surface.render(kRay, T_w_f * lookingAlong(from, direction)).at(0, 0);
  return isMeasured(z) ? z : std::numeric_limits<double>::infinity();
}

}  // namespace facetloc::internal
