// SPDX-License-Identifier: BSD-3-Clause
#include "base/lanes.h"

#include <facetloc/features/depth_picture.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace facetloc {

using namespace internal;
namespace {

// The smaller known value, in steps from 1 so that 0 = unknown comes last; or the larger one.
struct Smallest {
  static std::uint16_t of(std::uint16_t a, std::uint16_t b) {
    return static_cast<std::uint16_t>(std::min<std::uint16_t>(a - 1, b - 1) + 1);
  }
};
struct Largest {
  static std::uint16_t of(std::uint16_t a, std::uint16_t b) { return std::max(a, b); }
};

// Over 3x3 neighbours: first each row's triples, then each column's triples of those, in place.
template <typename Extreme>
FACETLOC_ALWAYS_INLINE void extremeOf3x3(const std::uint16_t* in, int width, int height, std::uint16_t* out) {
  for (int v = 0; v < height; ++v) {
    const std::uint16_t* row = in + static_cast<std::size_t>(v) * width;
    std::uint16_t* rows = out + static_cast<std::size_t>(v) * width;
    rows[0] = width > 1 ? Extreme::of(row[0], row[1]) : row[0];
    for (int u = 1; u + 1 < width; ++u) rows[u] = Extreme::of(Extreme::of(row[u - 1], row[u]), row[u + 1]);
    if (width > 1) rows[width - 1] = Extreme::of(row[width - 2], row[width - 1]);
  }
  constexpr int kStrip = 64;  // columns whose row above is kept while the rows are overwritten
  for (int u0 = 0; u0 < width; u0 += kStrip) {
    const int n = std::min(kStrip, width - u0);
    std::uint16_t above[kStrip] = {};
    for (int v = 0; v < height; ++v) {
      std::uint16_t* row = out + static_cast<std::size_t>(v) * width + u0;
      const std::uint16_t* below = v + 1 < height ? row + width : row;
      for (int k = 0; k < n; ++k) {
        const std::uint16_t here = row[k];
        const std::uint16_t best = Extreme::of(here, below[k]);
        row[k] = v > 0 ? Extreme::of(best, above[k]) : best;
        above[k] = here;
      }
    }
  }
}

FACETLOC_MULTIVERSION void smallestOf3x3(const std::uint16_t* in, int width, int height, std::uint16_t* out) {
  extremeOf3x3<Smallest>(in, width, height, out);
}
FACETLOC_MULTIVERSION void largestOf3x3(const std::uint16_t* in, int width, int height, std::uint16_t* out) {
  extremeOf3x3<Largest>(in, width, height, out);
}

// Every second depth of a row as inverse depth in quanta; 0 = not measured or out of range.
FACETLOC_MULTIVERSION void quantize(const float* z, int n, std::uint16_t* out) {
  constexpr float kLargest = std::numeric_limits<std::uint16_t>::max();
  for (int u = 0; u < n; ++u) {
    const float depth = z[2 * u];
    const double steps = 1.0 / (depth * DepthPicture::kQuantum) + 0.5;
    const bool known =
        (depth >= kNearestMeasured) & (depth <= kFarthestMeasured) & (steps >= 1) & (steps < kLargest + 1.0);
    out[u] = static_cast<std::uint16_t>(static_cast<std::int32_t>(known ? steps : 0.0));
  }
}

}  // namespace

DepthPicture DepthPicture::fromDepth(const DepthImage& image) {
  DepthPicture p;
  p.assign(image);
  return p;
}

void DepthPicture::assign(const DepthImage& image) {
  camera = {};
  inverse_depth.clear();
  if (image.valid()) {
    camera = image.camera.subsampled(2);
    inverse_depth.resize(static_cast<std::size_t>(camera.width) * camera.height);
    for (int v = 0; v < camera.height; ++v)
      quantize(image.depth.data() + 2 * static_cast<std::size_t>(v) * image.camera.width, camera.width,
               inverse_depth.data() + static_cast<std::size_t>(v) * camera.width);
  }
  deriveExtremes();
}

DepthPicture DepthPicture::fromStored(const Intrinsics& camera, std::vector<std::uint16_t> inverse_depth) {
  if (!camera.valid() || inverse_depth.size() != static_cast<std::size_t>(camera.width) * camera.height)
    throw std::invalid_argument("a depth picture needs one value per pixel of its camera");
  DepthPicture p;
  p.camera = camera;
  p.inverse_depth = std::move(inverse_depth);
  p.deriveExtremes();
  return p;
}

void DepthPicture::deriveExtremes() {
  // Memory that stays: a running camera needs no new one for its views.
  static thread_local std::vector<std::uint16_t> lowest, highest;
  lowest.resize(inverse_depth.size()), highest.resize(inverse_depth.size());
  smallestOf3x3(inverse_depth.data(), camera.width, camera.height, lowest.data());
  largestOf3x3(inverse_depth.data(), camera.width, camera.height, highest.data());
  extremes.resize(inverse_depth.size());
  for (std::size_t i = 0; i < extremes.size(); ++i) extremes[i] = {lowest[i], highest[i]};
}

}  // namespace facetloc
