// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>
#include <facetloc/features/depth_image.h>

namespace facetloc {

/** \brief The noise of a depth image: that of its camera, raised to what the image itself shows, also where it
 * is smooth over many pixels (segmentation/METHOD 2.2, 2.3). The camera's for an empty image. */
SensorNoise measuredNoise(const DepthImage& image, const SensorNoise& of_camera);

}  // namespace facetloc
