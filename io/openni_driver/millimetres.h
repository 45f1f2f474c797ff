// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "frame_source.h"

#include <facetloc/features/depth_image.h>

#include <algorithm>
#include <cmath>

namespace facetloc {

/** \brief Depth in OpenNI2's unit; values out of its range become 0. */
inline void toMillimetres(const DepthImage& image, std::uint16_t* depth) {
  std::transform(image.depth.begin(), image.depth.end(), depth, [](float z) {
    const float millimetres = std::round(1000.f * z);
    const bool fits = isMeasured(z) && millimetres < static_cast<float>(kMaxDepthMillimetres);
    return fits ? static_cast<std::uint16_t>(millimetres) : std::uint16_t(0);
  });
}

}  // namespace facetloc
