// SPDX-License-Identifier: BSD-3-Clause
#include "models/view_cover.h"

#include <algorithm>
#include <cmath>
#include <queue>

namespace facetloc::internal {
namespace {

/** Does a picture show this depth at a pixel or between it and its neighbours? */
bool shows(const SmallView& view, const Intrinsics& camera, const Eigen::Vector2d& pixel, double z) {
  constexpr double kSlack = 0.05;  // share of depth
  const int u = static_cast<int>(std::lround(pixel.x())), v = static_cast<int>(std::lround(pixel.y()));
  if (u < 0 || v < 0 || u >= camera.width || v >= camera.height) return false;
  float least = 0, most = 0;
  for (int y = std::max(0, v - 1); y <= std::min(v + 1, camera.height - 1); ++y)
    for (int x = std::max(0, u - 1); x <= std::min(u + 1, camera.width - 1); ++x) {
      const float d = view.depth[static_cast<std::size_t>(y) * camera.width + x];
      if (d <= 0) continue;
      least = least > 0 ? std::min(least, d) : d;
      most = std::max(most, d);
    }
  return z >= least * (1 - kSlack) && z <= most * (1 + kSlack);
}

}  // namespace

double sharedPart(const SmallView& of, const SmallView& in, const Intrinsics& camera) {
  const Eigen::Isometry3d T = in.T_w_c.inverse() * of.T_w_c;
  int known = 0, shared = 0;
  for (int v = 0; v < camera.height; v += 2)
    for (int u = 0; u < camera.width; u += 2) {
      const double z = of.depth[static_cast<std::size_t>(v) * camera.width + u];
      if (z <= 0) continue;
      ++known;
      const Eigen::Vector3d p = T * Eigen::Vector3d(camera.ray(u, v) * z);
      shared += p.z() > 0 && shows(in, camera, camera.project(p), p.z());
    }
  return known > 0 ? static_cast<double>(shared) / known : 0;
}

std::vector<std::size_t> coveringViews(const Substitutes& substitutes, double shared) {
  const std::size_t n = substitutes.of.size();
  std::vector<std::uint8_t> covered(n);
  const auto gain = [&](std::size_t i) {  // the view itself is covered by nothing better
    int count = covered[i] ? 0 : 1;
    for (const Substitutes::Entry& entry : substitutes.of[i])
      count += !covered[entry.view] && entry.shared >= shared;
    return count;
  };
  using Choice = std::pair<int, std::ptrdiff_t>;  // gain, and minus the view: the first of equals wins
  std::priority_queue<Choice> queue;
  for (std::size_t i = 0; i < n; ++i) queue.emplace(gain(i), -static_cast<std::ptrdiff_t>(i));
  std::vector<std::size_t> chosen;
  while (!queue.empty()) {
    const auto [expected, minus] = queue.top();
    queue.pop();
    const auto view = static_cast<std::size_t>(-minus);
    const int now = gain(view);  // gains only fall
    if (now == 0) continue;
    if (now < expected) {
      queue.emplace(now, minus);
      continue;
    }
    chosen.push_back(view);
    covered[view] = 1;
    for (const Substitutes::Entry& entry : substitutes.of[view])
      if (entry.shared >= shared) covered[entry.view] = 1;
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

}  // namespace facetloc::internal
