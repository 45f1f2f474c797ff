// SPDX-License-Identifier: BSD-3-Clause
#include "surface_errors.h"

#include <algorithm>
#include <cmath>

namespace facetloc {
namespace {

constexpr double kGap = 0.05;       // [1/m] a smaller step of inverse depth is no silhouette
constexpr double kReach = 0.3;      // [m] of light between two surfaces
constexpr double kInFront = 0.005;  // [m] a surface that faces another lies at least so far before it

/** Sums of inverse depths, and how many of them, weighted. */
struct WeightedSums {
  std::vector<double> sum, weight;

  double mean(std::size_t i) const { return weight[i] > 0 ? sum[i] / weight[i] : 0; }
};

/** Sums along an axis of n pixels that are so far apart, over all lines of it, the first ones of which are
 * given. */
WeightedSums alongAxis(const WeightedSums& image, const std::vector<double>& kernel, int n, int stride,
                       int lines, int between_lines) {
  const int radius = static_cast<int>(kernel.size()) - 1;
  WeightedSums out{std::vector<double>(image.sum.size(), 0.0), std::vector<double>(image.sum.size(), 0.0)};
  for (int line = 0; line < lines; ++line)
    for (int i = 0; i < n; ++i) {
      const std::size_t to = std::size_t(line) * between_lines + std::size_t(i) * stride;
      for (int k = std::max(0, i - radius); k <= std::min(n - 1, i + radius); ++k) {
        const std::size_t from = std::size_t(line) * between_lines + std::size_t(k) * stride;
        out.sum[to] += kernel[std::abs(k - i)] * image.sum[from];
        out.weight[to] += kernel[std::abs(k - i)] * image.weight[from];
      }
    }
  return out;
}

/** Around each pixel, of the inverse depths that are known (0 = not). */
WeightedSums gaussianSums(const std::vector<double>& inverse, const Intrinsics& camera, double sigma) {
  constexpr double kSigmas = 3;
  std::vector<double> kernel;
  for (int k = 0; k <= std::ceil(kSigmas * sigma); ++k)
    kernel.push_back(std::exp(-0.5 * k * k / (sigma * sigma)));
  WeightedSums image{inverse, std::vector<double>(inverse.size())};
  std::transform(inverse.begin(), inverse.end(), image.weight.begin(), [](double d) { return d > 0; });
  const int width = camera.width, height = camera.height;
  return alongAxis(alongAxis(image, kernel, width, 1, height, width), kernel, height, width, width, 1);
}

std::vector<double> inverted(std::vector<double> values) {
  for (double& value : values) value = value > 0 ? 1 / value : 0;
  return values;
}

/** Makes pixels near a step of inverse depth unknown. */
std::vector<double> withoutSilhouettes(const std::vector<double>& inverse, const Intrinsics& camera,
                                       int radius) {
  std::vector<double> out = inverse;
  const auto at = [&](int u, int v) { return std::size_t(v) * camera.width + u; };
  const auto isStep = [&](std::size_t a, std::size_t b) {
    return inverse[a] > 0 && inverse[b] > 0 && std::abs(inverse[a] - inverse[b]) > kGap;
  };
  for (int v = 0; v + 1 < camera.height; ++v)
    for (int u = 0; u + 1 < camera.width; ++u) {
      if (!isStep(at(u, v), at(u + 1, v)) && !isStep(at(u, v), at(u, v + 1))) continue;
      for (int y = std::max(0, v - radius + 1); y <= std::min(camera.height - 1, v + radius); ++y)
        for (int x = std::max(0, u - radius + 1); x <= std::min(camera.width - 1, u + radius); ++x)
          out[at(x, y)] = 0;
    }
  return out;
}

}  // namespace

std::vector<int> fattened(const Hits& hits, const Intrinsics& camera, double px) {
  const int radius = static_cast<int>(std::lround(px));
  if (radius < 1) return hits.surface;
  // The nearest pixel around, first of the row, then of these.
  std::vector<std::size_t> of_row(hits.depth.size()), nearest(hits.depth.size());
  const auto isNearer = [&](std::size_t a, std::size_t b) { return hits.depth[a] < hits.depth[b]; };
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      const std::size_t row = std::size_t(v) * camera.width;
      std::size_t best = row + u;
      for (int x = std::max(0, u - radius); x <= std::min(camera.width - 1, u + radius); ++x)
        if (isNearer(row + x, best)) best = row + x;
      of_row[row + u] = best;
    }
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      std::size_t best = of_row[std::size_t(v) * camera.width + u];
      for (int y = std::max(0, v - radius); y <= std::min(camera.height - 1, v + radius); ++y)
        if (const std::size_t other = of_row[std::size_t(y) * camera.width + u]; isNearer(other, best))
          best = other;
      nearest[std::size_t(v) * camera.width + u] = best;
    }
  std::vector<int> seen(hits.surface);
  for (std::size_t i = 0; i < seen.size(); ++i)
    if (1 / hits.depth[nearest[i]] - 1 / hits.depth[i] > kGap) seen[i] = hits.surface[nearest[i]];
  return seen;
}

double cornerShare(const Hits& hits, const Intrinsics& camera, int u, int v) {
  const std::size_t i = std::size_t(v) * camera.width + u;
  if (hits.surface[i] == kNothing) return 0;
  const Eigen::Vector3d p = hits.depth[i] * camera.ray(u, v);
  Eigen::Vector3d n = hits.with(hits.surface[i], [&](const auto& seen) { return seen.normalAt(p); });
  if (n.dot(p) > 0) n = -n;
  double nearest = kReach;
  for (const double away : {0.02, 0.05, 0.1, 0.15, 0.2, 0.3}) {
    const int px = std::max(1, static_cast<int>(std::lround(away * camera.fx / p.z())));
    for (const auto& [du, dv] : {std::pair(px, 0), std::pair(-px, 0), std::pair(0, px), std::pair(0, -px)}) {
      const int x = u + du, y = v + dv;
      if (x < 0 || y < 0 || x >= camera.width || y >= camera.height) continue;
      const std::size_t j = std::size_t(y) * camera.width + x;
      if (hits.surface[j] == kNothing || hits.surface[j] == hits.surface[i]) continue;
      const Eigen::Vector3d way = hits.depth[j] * camera.ray(x, y) - p;
      if (n.dot(way) > kInFront) nearest = std::min(nearest, way.norm());
    }
  }
  return 1 - nearest / kReach;
}

std::vector<double> blurred(const std::vector<double>& depth, const Intrinsics& camera, double px) {
  std::vector<double> inverse = inverted(depth);
  const WeightedSums around = gaussianSums(inverse, camera, px);
  for (std::size_t i = 0; i < inverse.size(); ++i)
    if (inverse[i] > 0) inverse[i] = around.mean(i);
  return inverted(std::move(inverse));
}

std::vector<double> filledIn(const std::vector<double>& depth, const Intrinsics& camera, double px) {
  const int radius = std::max(1, static_cast<int>(std::lround(px)));
  const std::vector<double> known = withoutSilhouettes(inverted(depth), camera, radius);
  std::vector<double> filled = known;
  // Each wider window fills those gaps that the narrower ones did not reach across.
  for (double sigma = std::max(1.0, px / 2); sigma < camera.width; sigma *= 2) {
    if (std::find(filled.begin(), filled.end(), 0.0) == filled.end()) break;
    const WeightedSums around = gaussianSums(known, camera, sigma);
    for (std::size_t i = 0; i < filled.size(); ++i)
      if (!(filled[i] > 0)) filled[i] = around.mean(i);
  }
  return inverted(std::move(filled));
}

}  // namespace facetloc
