// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/depth_image.h>
#include <facetloc/features/impl/inverse_depth.h>
#include <facetloc/features/impl/lanes.h>

#include <algorithm>

namespace facetloc {

FACETLOC_MULTIVERSION void invertDepth(const float* depth, std::size_t n, float scale, float* out) {
  for (std::size_t i = 0; i < n; i += kLanes) {
    Floats z;
    load(depth + i, depth + n, z);
    const Floats inverse = scale / z;
    store((z >= kNearestMeasured) & (z <= kFarthestMeasured) ? inverse : Floats{}, out + i, out + n);
  }
}

DepthImage subsampled(const DepthImage& image, int step) {
  if (step <= 1 || !image.valid()) return image;
  DepthImage out;
  out.camera = image.camera.subsampled(step);
  out.depth.reserve(static_cast<std::size_t>(out.camera.width) * out.camera.height);
  for (int v = 0; v < image.camera.height; v += step)
    for (int u = 0; u < image.camera.width; u += step) out.depth.push_back(image.at(u, v));
  return out;
}

int subsamplingStep(const Intrinsics& camera, int working_width) {
  return working_width > 0 ? std::max(1, camera.width / working_width) : 1;
}

int LabelImage::maxLabel() const { return label.empty() ? 0 : *std::max_element(label.begin(), label.end()); }

}  // namespace facetloc
