// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/inverse_depth.h"

#include <facetloc/features/depth_image.h>

#include <vector>

namespace facetloc::internal {

/** \brief Inverse depth in units of its own noise: a disparity image whose standard deviation is 1
 * everywhere.
 *
 * All segmentation is done here: planes of space are planes of (u, v, d), noise is homoscedastic, and
 * thresholds are plain multiples of the noise, whatever the sensor (METHOD 1). 0 = not measured; measured
 * values are positive. */
struct DisparityImage {
  Intrinsics camera;
  double unit = 1;  ///< inverse depth of one step [1/m]
  std::vector<float> d;
};

/** \brief Least share of measured pixels of a triangle or a square that is a plane: with fewer, the plane is
 * extrapolated. */
constexpr double kMinFill = 0.5;

/** \brief Depth to disparity in units of the given inverse-depth noise [1/m]. */
inline void toDisparity(const DepthImage& image, double unit, DisparityImage& out) {
  out.camera = image.camera;
  out.unit = unit;
  out.d.resize(image.depth.size());
  invertDepth(image.depth.data(), image.depth.size(), static_cast<float>(1.0 / unit), out.d.data());
}

}  // namespace facetloc::internal
