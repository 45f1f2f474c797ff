// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/depth_image.h>

#include <algorithm>
#include <array>

namespace facetloc {
namespace {

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

}  // namespace facetloc
