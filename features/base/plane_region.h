// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/segment_estimation.h>

namespace facetloc::internal {

/** \brief The data of a segment: a plane and the moments of the pixels that support it, in the frame of
 * the camera. */
struct PlaneRegion {
  double support = 0;                                    ///< [px of the image]
  Eigen::Vector3d m = Eigen::Vector3d::Zero();           ///< coefficients of the plane m . p = 1 [1/m]
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();        ///< mean of the points [m]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< covariance of the points [m^2]
  Eigen::Matrix3d rays = Eigen::Matrix3d::Zero();        ///< sum of b b^T over the pixels, p = z b
};

/** \brief Everything of a segment but its hull (METHOD 7); false if it fails one of the tests of METHOD 8. */
bool describe(const PlaneRegion& region, const Intrinsics& camera, const SensorNoise& noise,
              const SegmentEstimationParams& params, Segment& s, const char*& why_not);

}  // namespace facetloc::internal
