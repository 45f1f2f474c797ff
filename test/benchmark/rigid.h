// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

namespace facetloc::benchmarks {

/** \brief The pose that a registration of PCL answers, whose rotation is rounded. */
inline Eigen::Isometry3d rigid(const Eigen::Matrix4f& matrix) {
  return Eigen::Translation3d(matrix.topRightCorner<3, 1>().cast<double>()) *
         Eigen::Isometry3d(
             Eigen::Quaterniond(matrix.topLeftCorner<3, 3>().cast<double>()).normalized().toRotationMatrix());
}

}  // namespace facetloc::benchmarks
