// SPDX-License-Identifier: BSD-3-Clause
#include "surface_errors.h"

namespace facetloc {
namespace {

constexpr double kGap = 0.05;       // [1/m] a smaller step of inverse depth is no silhouette
constexpr double kReach = 0.3;      // [m] of light between two surfaces
constexpr double kInFront = 0.005;  // [m] a surface that faces another lies at least so far before it

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

}  // namespace facetloc
