// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

namespace facetloc {

/** \name Kinect v1 (METHOD 2.1): z = kKinectGain / (kKinectOffset - d), d the raw disparity in 1/8 px. */
/// @{
constexpr double kKinectGain = 351.218540681877;    ///< [m DU]
constexpr double kKinectOffset = 1092.93080891449;  ///< [DU]
inline double kinectDisparity(double z) { return kKinectOffset - kKinectGain / z; }
inline double kinectDepth(double disparity) { return kKinectGain / (kKinectOffset - disparity); }
/// @}

/** \brief Random error of the depths of a camera, over their range (METHOD 2.2):
 *
 *     sigma_z(z) = depth_std + depth_std_slope z + inverse_depth_std z^2
 *
 * The square is due to triangulation (Kinect, stereo), the rest to the time of flight (ToF,
 * lidar). The default is a Kinect v1. */
struct DepthNoise {
  static constexpr double kLeastInverseDepthStd = 1e-7;  ///< less counts as this: disparities stay finite
  static constexpr double kLargestInverseDepthStd = 1;   ///< [1/m]
  static constexpr double kLargestDepthStd = 1;          ///< [m]
  static constexpr double kLargestDepthStdSlope = 0.5;   ///< [m] per metre of depth
  static constexpr double kUsualDepth = 2;  ///< where one number has to stand for an image or a camera [m]

  double inverse_depth_std = 0.5 / kKinectGain;  ///< part that is the same in inverse depth [1/m]
  double depth_std = 0;                          ///< part that is the same in depth [m]
  double depth_std_slope = 0;                    ///< part that is proportional to depth

  /** \brief Standard deviation of 1/z at depth z > 0 [1/m]. */
  double ofInverseDepth(double z) const { return inverse_depth_std + (depth_std_slope + depth_std / z) / z; }
  /** \brief Standard deviation of z at depth z > 0 [m]. */
  double ofDepth(double z) const { return depth_std + (depth_std_slope + inverse_depth_std * z) * z; }
  /** \brief True if the error of inverse depth is the same at all distances. */
  bool isConstantInInverseDepth() const { return depth_std == 0 && depth_std_slope == 0; }

  /** \brief The noise of an image that has this standard deviation of 1/z [1/m] at depth z: all parts are
   * larger, or smaller, by one factor. */
  DepthNoise scaledTo(double inverse_std, double z) const {
    const double factor = inverse_std / std::max(kLeastInverseDepthStd, ofInverseDepth(z));
    DepthNoise scaled;
    scaled.depth_std = depth_std * factor;
    scaled.depth_std_slope = depth_std_slope * factor;
    // Computed as the remainder, so that the sum is exactly the one required.
    scaled.inverse_depth_std =
        std::max(kLeastInverseDepthStd, inverse_std - (scaled.depth_std_slope + scaled.depth_std / z) / z);
    return scaled;
  }
};

}  // namespace facetloc
