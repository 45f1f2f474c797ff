// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>
#include <facetloc/features/depth_image.h>

namespace facetloc {

/** \brief Noise of a depth image, measured from its second differences, rough or smooth over many pixels
 * (segmentation/METHOD 2.2, 2.3); at least the noise of its camera, which an empty image has. */
SensorNoise measuredNoise(const DepthImage& image, const SensorNoise& of_camera);

}  // namespace facetloc
