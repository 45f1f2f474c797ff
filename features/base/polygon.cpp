// SPDX-License-Identifier: BSD-3-Clause
#include "base/polygon.h"

#include <cmath>
#include <limits>

namespace facetloc::internal {
namespace {

double cross(const Eigen::Vector2d& o, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return (a - o).x() * (b - o).y() - (a - o).y() * (b - o).x();
}

}  // namespace

void convexHull(const Polygon& points, Polygon& hull) {
  hull.clear();
  if (points.size() < 3) {
    hull = points;
    return;
  }
  const auto chain = [&hull](auto begin, auto end) {
    const std::size_t base = hull.size();
    for (auto it = begin; it != end; ++it) {
      while (hull.size() >= base + 2 && cross(hull[hull.size() - 2], hull.back(), *it) <= 0) hull.pop_back();
      hull.push_back(*it);
    }
    hull.pop_back();  // the last point of one chain is the first of the other
  };
  chain(points.begin(), points.end());
  chain(points.rbegin(), points.rend());
}

void simplify(Polygon& hull, std::size_t n) {
  while (hull.size() > n) {
    std::size_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < hull.size(); ++i) {
      const double lost =
          std::abs(cross(hull[(i + hull.size() - 1) % hull.size()], hull[i], hull[(i + 1) % hull.size()]));
      if (lost < least) least = lost, best = i;
    }
    hull.erase(hull.begin() + best);
  }
}

}  // namespace facetloc::internal
