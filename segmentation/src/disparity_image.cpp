// SPDX-License-Identifier: BSD-3-Clause
#include "disparity_image.h"

#include "base/inverse_depth.h"

namespace facetloc::internal {

void toDisparity(const DepthImage& image, double unit, DisparityImage& out) {
  out.camera = image.camera;
  out.unit = unit;
  out.d.resize(image.depth.size());
  invertDepth(image.depth.data(), image.depth.size(), static_cast<float>(1.0 / unit), out.d.data());
}

}  // namespace facetloc::internal
