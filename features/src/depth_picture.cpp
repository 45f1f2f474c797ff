// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/depth_picture.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace facetloc {
namespace {

// Smallest (largest) known value of each row's triples, then of each column's triples of those: separable.
template <typename Better>
std::vector<std::uint16_t> extremeOf3x3(const Intrinsics& c, const std::vector<std::uint16_t>& in,
                                        Better better) {
  const auto pick = [better](std::uint16_t a, std::uint16_t b) {
    return a == 0 ? b : (b == 0 || better(a, b) ? a : b);
  };
  std::vector<std::uint16_t> rows(in.size()), out(in.size());
  for (int v = 0; v < c.height; ++v)
    for (int u = 0; u < c.width; ++u) {
      const std::size_t i = static_cast<std::size_t>(v) * c.width + u;
      std::uint16_t x = in[i];
      if (u > 0) x = pick(x, in[i - 1]);
      if (u + 1 < c.width) x = pick(x, in[i + 1]);
      rows[i] = x;
    }
  for (int v = 0; v < c.height; ++v)
    for (int u = 0; u < c.width; ++u) {
      const std::size_t i = static_cast<std::size_t>(v) * c.width + u;
      std::uint16_t x = rows[i];
      if (v > 0) x = pick(x, rows[i - c.width]);
      if (v + 1 < c.height) x = pick(x, rows[i + c.width]);
      out[i] = x;
    }
  return out;
}

}  // namespace

DepthPicture DepthPicture::fromDepth(const DepthImage& image) {
  if (!image.valid()) return {};
  const DepthImage half = subsampled(image, 2);
  constexpr double largest = std::numeric_limits<std::uint16_t>::max();
  std::vector<std::uint16_t> stored(half.depth.size());
  std::transform(half.depth.begin(), half.depth.end(), stored.begin(), [](float z) {
    if (!isMeasured(z)) return std::uint16_t{0};
    const double steps = std::round(1.0 / (z * kQuantum));
    return steps >= 1 && steps <= largest ? static_cast<std::uint16_t>(steps) : std::uint16_t{0};
  });
  return fromStored(half.camera, std::move(stored));
}

DepthPicture DepthPicture::fromStored(const Intrinsics& camera, std::vector<std::uint16_t> inverse_depth) {
  if (!camera.valid() || inverse_depth.size() != static_cast<std::size_t>(camera.width) * camera.height)
    throw std::invalid_argument("a depth picture needs one value per pixel of its camera");
  DepthPicture p;
  p.camera = camera;
  p.lowest = extremeOf3x3(camera, inverse_depth, [](auto a, auto b) { return a < b; });
  p.highest = extremeOf3x3(camera, inverse_depth, [](auto a, auto b) { return a > b; });
  p.inverse_depth = std::move(inverse_depth);
  return p;
}

}  // namespace facetloc
