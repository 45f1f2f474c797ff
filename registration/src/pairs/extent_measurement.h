// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/pose.h>
#include <facetloc/features/segment.h>

namespace facetloc::internal {

/** \brief Where two segments are that overlap, along their common plane (METHOD 6.6): the distance of the
 * centroids of the parts that either view shows, in the axes x' and y' of the model segment. It fixes
 * the motions that the planes of small surfaces leave free; for large ones it has little information. */
struct ExtentMeasurement {
  Eigen::Vector2d h;              ///< distance of the centroids [m]
  Eigen::Matrix<double, 2, 6> H;  ///< dh/dw by a left, decoupled perturbation of T_m_c
  Eigen::Matrix2d W;              ///< variance of h among all positions at which the two overlap [m^2]
};

/** \brief The measurement at a pose. */
ExtentMeasurement measureExtent(const Segment& scene, const Segment& model, const Eigen::Isometry3d& T_m_c);

/** \brief H^T W^-1 H; zero where W is singular. */
Matrix6d informationOf(const ExtentMeasurement& m);

}  // namespace facetloc::internal
