// SPDX-License-Identifier: BSD-3-Clause
#include "disparity_image.h"

#include "float_bits.h"
#include "shared/inverse_depth.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace facetloc::internal {
namespace {

// The median of n floats that are not negative, the upper of two; moves them about. Counting by exponent and
// first digits leaves a few percent of them to sort.
float median(float* x, std::size_t n) {
  constexpr int kUnsorted = 20;  // bits
  std::array<std::uint32_t, 1u << (32 - kUnsorted)> count{};
  for (std::size_t i = 0; i < n; ++i) ++count[bitsOf(x[i]) >> kUnsorted];
  std::size_t bin = 0, rank = n / 2;
  for (; rank >= count[bin]; ++bin) rank -= count[bin];
  float* const end = std::partition(x, x + n, [&](float y) { return bitsOf(y) >> kUnsorted == bin; });
  std::nth_element(x, x + rank, end);
  return x[rank];
}

}  // namespace

Differences secondDifferences(const DepthImage& image, int apart, int rows, std::vector<float>& scratch) {
  const int w = image.camera.width, step = std::max(1, image.camera.height / rows);
  scratch.resize(w + static_cast<std::size_t>(w) * (image.camera.height / step + 1));
  float* const row = scratch.data();  // of inverse depths; behind it the differences
  float* const differences = row + w;
  float* next = differences;
  for (int v = step / 2; v < image.camera.height; v += step) {
    invertDepth(image.depth.data() + static_cast<std::size_t>(v) * w, w, 1.f, row);
    for (int u = apart; u + apart < w; ++u) {
      *next = std::abs(row[u - apart] - 2 * row[u] + row[u + apart]);
      next += row[u - apart] > 0 && row[u] > 0 && row[u + apart] > 0;
    }
  }
  return {differences, next};
}

double noiseByDifferences(const DepthImage& image, int apart, int rows, std::vector<float>& scratch) {
  constexpr double kMadToStd = 1.4826;
  const double scale =
      kMadToStd / std::sqrt(6.0);  // the variance of d0 - 2 d1 + d2 is 6 for unit white noise
  const Differences found = secondDifferences(image, apart, rows, scratch);
  return found.few() ? 0 : scale * median(found.begin, found.size());
}

double estimateNoise(const DepthImage& image, double least) {
  std::vector<float> scratch;
  return estimateNoise(image, least, scratch);
}

double estimateNoise(const DepthImage& image, double least, std::vector<float>& scratch) {
  constexpr int kRows = 60;          // give the median to a percent
  constexpr int kFewRows = 20;       // tell smooth noise well enough
  constexpr double kApart = 6;       // pixels at 320 columns: most triples of a room lie in one surface
  constexpr double kOfSmooth = 0.5;  // tolerances of several standard deviations bear the rest
  if (!image.valid()) return least;
  const int apart = static_cast<int>(std::lround(kApart * std::sqrt(scaledPixels(1, image.camera))));
  return std::max({least, noiseByDifferences(image, 1, kRows, scratch),
                   kOfSmooth * noiseByDifferences(image, std::max(1, apart), kFewRows, scratch)});
}

void toDisparity(const DepthImage& image, double unit, DisparityImage& out) {
  out.camera = image.camera;
  out.unit = unit;
  out.d.resize(image.depth.size());
  invertDepth(image.depth.data(), image.depth.size(), static_cast<float>(1.0 / unit), out.d.data());
}

}  // namespace facetloc::internal
