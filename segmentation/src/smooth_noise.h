// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>

#include <optional>
#include <vector>

namespace facetloc::internal {

/** \brief Noise that neighbouring pixels share, as a stereo camera has it: a wall becomes wavy rather than
 * rough. Its correlation over the distance r is exp(-r^2 / correlation_px^2). */
struct SmoothNoise {
  double std;             ///< of inverse depth [1/m]
  double correlation_px;  ///< [px of the image]
};

/** \brief Looks how the second differences of an image grow with the distance of the pixels (METHOD 2.3).
 * None if neighbours differ about as much as pixels farther apart, as for a Kinect. */
std::optional<SmoothNoise> estimateSmoothNoise(const DepthImage& image, std::vector<float>& scratch);

}  // namespace facetloc::internal
