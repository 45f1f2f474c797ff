// SPDX-License-Identifier: BSD-3-Clause
#include "base/inverse_depth.h"
#include "base/lanes.h"
#include "base/median.h"

#include <facetloc/features/depth_image.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

namespace facetloc::internal {

FACETLOC_MULTIVERSION void invertDepth(const float* depth, std::size_t n, float scale, float* out) {
  for (std::size_t i = 0; i < n; i += kLanes) {
    Floats z;
    load(depth + i, depth + n, z);
    const Floats inverse = scale / z;
    store(((z >= kNearestMeasured) & (z <= kFarthestMeasured)) ? inverse : Floats{}, out + i, out + n);
  }
}

}  // namespace facetloc::internal

namespace facetloc {

using namespace internal;

namespace {

// The first measured pixel of a block, row by row; 0 if no pixel is measured.
float firstMeasured(const DepthImage& image, int u0, int v0, int step) {
  const int u1 = std::min(u0 + step, image.camera.width), v1 = std::min(v0 + step, image.camera.height);
  for (int v = v0; v < v1; ++v)
    for (int u = u0; u < u1; ++u)
      if (isMeasured(image.at(u, v))) return image.at(u, v);
  return 0;
}

constexpr int kLargestReach = 3;

bool isMeasuredAt(const DepthImage& image, int u, int v) {
  return u >= 0 && v >= 0 && u < image.camera.width && v < image.camera.height && isMeasured(image.at(u, v));
}

/** How far the measured pixels around a hole are, in all four quadrants about it; beyond the largest reach if
 * there are none in one. */
int reachOf(const DepthImage& image, int u, int v) {
  constexpr int kAll = 0b1111;
  int quadrants = 0;
  const auto add = [&](int du, int dv) {
    if (!isMeasuredAt(image, u + du, v + dv)) return;
    if (du >= 0) quadrants |= (dv >= 0 ? 1 : 0) | (dv <= 0 ? 2 : 0);
    if (du <= 0) quadrants |= (dv >= 0 ? 4 : 0) | (dv <= 0 ? 8 : 0);
  };
  for (int reach = 1; reach <= kLargestReach; ++reach) {
    for (int k = -reach; k <= reach; ++k) add(k, -reach), add(k, reach), add(-reach, k), add(reach, k);
    if (quadrants == kAll) return reach;
  }
  return kLargestReach + 1;
}

/** Between the measured pixels around a hole. */
float filled(const DepthImage& image, int u, int v, int reach) {
  constexpr float kOfOneSurface = 0.02f;  // share of inverse depth
  float nearest = 0, least = 0, most = 0, sum = 0, weights = 0;
  int least_distance = 2 * reach * reach + 1;
  for (int j = v - reach; j <= v + reach; ++j)
    for (int i = u - reach; i <= u + reach; ++i) {
      if (!isMeasuredAt(image, i, j)) continue;
      const int distance = (i - u) * (i - u) + (j - v) * (j - v);
      const float z = image.at(i, j), inverse = 1 / z, weight = 1 / static_cast<float>(distance);
      least = weights > 0 ? std::min(least, inverse) : inverse, most = std::max(most, inverse);
      sum += weight * inverse, weights += weight;
      if (distance < least_distance) least_distance = distance, nearest = z;
    }
  return most - least <= kOfOneSurface * most ? weights / sum : nearest;
}

template <typename Use>
void forEachHole(const DepthImage& image, const Use& use) {
  for (int v = 0; v < image.camera.height; ++v)
    for (int u = 0; u < image.camera.width; ++u)
      if (!isMeasured(image.at(u, v)))
        if (const int reach = reachOf(image, u, v); reach <= kLargestReach) use(u, v, reach);
}

}  // namespace

double usualDepth(const DepthImage& image) {
  constexpr std::size_t kPixels = 1024;
  if (!image.valid()) return DepthNoise::kUsualDepth;
  std::array<float, kPixels> depths;
  std::size_t n = 0;
  // Rows are no multiple of the stride, as a rule, so that all columns are asked; never more than fit.
  const std::size_t stride = (image.depth.size() + kPixels - 1) / kPixels | 1;
  for (std::size_t i = stride / 2; i < image.depth.size(); i += stride)
    if (isMeasured(image.depth[i])) depths[n++] = image.depth[i];
  if (n == 0) return DepthNoise::kUsualDepth;
  return internal::median(depths.begin(), depths.begin() + n);
}

void dropBeyond(double max_depth, DepthImage& image) {
  for (float& z : image.depth)
    if (z > max_depth) z = 0;
}

DepthImage subsampled(const DepthImage& image, int step) {
  constexpr double kMostLost = 0.2;  // share of the blocks with depth; along the holes of a Kinect it is 0.06
  if (step <= 1 || !image.valid()) return image;
  DepthImage out;
  out.camera = image.camera.subsampled(step);
  out.depth.reserve(static_cast<std::size_t>(out.camera.width) * out.camera.height);
  std::size_t kept = 0;
  std::vector<std::pair<std::size_t, float>> lost;  // where a block has depth, but not at its corner
  for (int v = 0; v < image.camera.height; v += step)
    for (int u = 0; u < image.camera.width; u += step) {
      const float corner = image.at(u, v);
      if (isMeasured(corner))
        ++kept;
      else if (const float other = firstMeasured(image, u, v, step); other > 0)
        lost.emplace_back(out.depth.size(), other);
      out.depth.push_back(corner);
    }
  if (static_cast<double>(lost.size()) > kMostLost * static_cast<double>(kept + lost.size()))
    for (const auto& [i, depth] : lost) out.depth[i] = depth;
  return out;
}

int subsamplingStep(const Intrinsics& camera, int working_width) {
  return working_width > 0 ? std::max(1, camera.width / working_width) : 1;
}

DepthImage workingImage(const DepthImage& image, int working_width) {
  return subsampled(image, subsamplingStep(image.camera, working_width));
}

LabelImage fullLabels(const LabelImage& labels, const DepthImage& image, int working_width) {
  const DepthImage small = workingImage(image, working_width);
  const Intrinsics &few = small.camera, &all = image.camera;
  if (!image.valid() || labels.width != few.width || labels.label.size() != small.depth.size())
    throw std::invalid_argument("labels and image differ in size");
  const int step = subsamplingStep(all, working_width);
  LabelImage full{all.width, all.height, std::vector<std::uint16_t>(image.depth.size(), 0)};
  for (int v = 0; v < all.height; ++v)
    for (int u = 0; u < all.width; ++u) {
      const float z = image.at(u, v);
      if (!isMeasured(z)) continue;
      float nearest = std::numeric_limits<float>::infinity();
      for (int y = v / step; y <= std::min((v + step - 1) / step, few.height - 1); ++y)
        for (int x = u / step; x <= std::min((u + step - 1) / step, few.width - 1); ++x) {
          const float off = std::abs(small.at(x, y) - z);
          if (!isMeasured(small.at(x, y)) || off >= nearest) continue;
          nearest = off;
          full.label[static_cast<std::size_t>(v) * all.width + u] =
              labels.label[static_cast<std::size_t>(y) * few.width + x];
        }
    }
  return full;
}

int LabelImage::maxLabel() const { return label.empty() ? 0 : *std::max_element(label.begin(), label.end()); }

int holeGridReach(const DepthImage& image) {
  constexpr double kLeastHoles = 0.5;  // share of the measured pixels; 1.25 finer images have 0.56
  constexpr double kNearlyAll = 0.9;
  if (!image.valid()) return 0;
  const auto measured =
      static_cast<double>(std::count_if(image.depth.begin(), image.depth.end(), isMeasured));
  std::array<double, kLargestReach + 1> holes{};  // indexed by reach
  double all = 0;
  if (static_cast<double>(image.depth.size()) - measured < kLeastHoles * measured) return 0;
  forEachHole(image, [&](int, int, int reach) { ++holes[static_cast<std::size_t>(reach)], ++all; });
  if (all == 0 || all < kLeastHoles * measured) return 0;
  double within = 0;
  for (int reach = 1; reach < kLargestReach; ++reach)
    if ((within += holes[static_cast<std::size_t>(reach)]) >= kNearlyAll * all) return reach;
  return kLargestReach;
}

void fillHoleGrid(DepthImage& image) {
  const int reach = holeGridReach(image);
  if (reach == 0) return;
  const DepthImage sparse = image;
  forEachHole(sparse, [&](int u, int v, int of_hole) {
    if (of_hole <= reach)
      image.depth[static_cast<std::size_t>(v) * static_cast<std::size_t>(image.camera.width) +
                  static_cast<std::size_t>(u)] = filled(sparse, u, v, reach);
  });
}

bool isDense(const DepthImage& image) {
  constexpr int kFew = 16;  // measured pixels that tell nothing of density
  int measured = 0, beside = 0;
  for (int v = 0; v + 1 < image.camera.height; ++v)
    for (int u = 0; u + 1 < image.camera.width; ++u) {
      if (!isMeasured(image.at(u, v))) continue;
      ++measured;
      beside += isMeasured(image.at(u + 1, v)) && isMeasured(image.at(u, v + 1));
    }
  return measured < kFew || 2 * beside >= measured;
}

}  // namespace facetloc
