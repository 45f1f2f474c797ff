// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/segmentation/disparity_image.h>

#include <algorithm>
#include <cmath>

namespace facetloc {

double estimateNoise(const DepthImage& image) {
  constexpr int kRowStep = 4;  // a quarter of the rows gives the median to a percent
  constexpr std::size_t kMinTriples = 100;
  constexpr double kMadToStd = 1.4826;
  const double scale =
      kMadToStd / std::sqrt(6.0);  // the variance of d0 - 2 d1 + d2 is 6 for unit white noise
  std::vector<float> difference;
  difference.reserve(image.depth.size() / kRowStep);
  for (int v = kRowStep / 2; v < image.camera.height; v += kRowStep)
    for (int u = 1; u + 1 < image.camera.width; ++u) {
      const float a = image.at(u - 1, v), b = image.at(u, v), c = image.at(u + 1, v);
      if (isMeasured(a) && isMeasured(b) && isMeasured(c))
        difference.push_back(std::abs(1 / a - 2 / b + 1 / c));
    }
  if (difference.size() < kMinTriples) return 0;
  const auto middle = difference.begin() + difference.size() / 2;
  std::nth_element(difference.begin(), middle, difference.end());
  return scale * *middle;
}

void toDisparity(const DepthImage& image, double unit, DisparityImage& out) {
  out.camera = image.camera;
  out.unit = unit;
  out.d.resize(image.depth.size());
  const float scale = static_cast<float>(1.0 / unit);
  std::transform(image.depth.begin(), image.depth.end(), out.d.begin(),
                 [scale](float z) { return isMeasured(z) ? scale / z : 0.f; });
}

}  // namespace facetloc
