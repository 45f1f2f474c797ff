// SPDX-License-Identifier: BSD-3-Clause
#include "models/straight_run.h"

#include <algorithm>
#include <cmath>

namespace facetloc::internal {
namespace {

/** The lines y = a x + b, |a| <= 1, that pass points within half a cell: a convex polygon of (a, b), which
 * every point cuts (O'Rourke, Comm. ACM 24, 1981). */
class PossibleLines {
public:
  /** \return false if no line is left. */
  bool add(double x, double y) {
    constexpr double kHalf = 0.5 + 1e-9;  // [cells]
    if (polygon_.empty()) {
      for (const double a : {-1.0, 1.0})
        for (const double side : {-a, a}) polygon_.emplace_back(a, y - a * x + side * kHalf);
      return true;
    }
    cut(x, y + kHalf, 1);
    if (!polygon_.empty()) cut(x, y - kHalf, -1);
    return !polygon_.empty();
  }

private:
  /** Keeps the part with sign (a x + b - y) <= 0. */
  void cut(double x, double y, double sign) {
    kept_.clear();
    for (std::size_t i = 0; i < polygon_.size(); ++i) {
      const Eigen::Vector2d &p = polygon_[i], &q = polygon_[(i + 1) % polygon_.size()];
      const double of_p = sign * (p.x() * x + p.y() - y), of_q = sign * (q.x() * x + q.y() - y);
      if (of_p <= 0) kept_.push_back(p);
      if ((of_p < 0 && of_q > 0) || (of_p > 0 && of_q < 0))
        kept_.push_back(p + of_p / (of_p - of_q) * (q - p));
    }
    polygon_.swap(kept_);
  }

  std::vector<Eigen::Vector2d> polygon_, kept_;
};

}  // namespace

LineFits::LineFits(const std::vector<Eigen::Vector2d>& points) : points_(points), sums_(points.size() + 1) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d p = points[i] - points[0];
    const Sums& before = sums_[i];
    sums_[i + 1] = {before.first + p, before.xx + p.x() * p.x(), before.xy + p.x() * p.y(),
                    before.yy + p.y() * p.y()};
  }
}

LineFits::Moments LineFits::momentsOf(std::size_t begin, std::size_t end) const {
  const Sums &a = sums_[begin], &b = sums_[end];
  const auto n = static_cast<double>(end - begin);
  const Eigen::Vector2d mean = (b.first - a.first) / n;
  return {mean, b.xx - a.xx - n * mean.x() * mean.x(), b.xy - a.xy - n * mean.x() * mean.y(),
          b.yy - a.yy - n * mean.y() * mean.y()};
}

double LineFits::squares(std::size_t begin, std::size_t end) const {
  const Moments m = momentsOf(begin, end);
  return std::max(0.0, (m.xx + m.yy - std::hypot(m.xx - m.yy, 2 * m.xy)) / 2);
}

FittedLine LineFits::line(std::size_t begin, std::size_t end) const {
  if (end - begin == 1) {
    // The middle of an edge along x has a whole y.
    const Eigen::Vector2d& p = points_[begin];
    return {p, p.y() == std::floor(p.y()) ? Eigen::Vector2d::UnitX() : Eigen::Vector2d::UnitY()};
  }
  const Moments m = momentsOf(begin, end);
  const double angle = std::atan2(2 * m.xy, m.xx - m.yy) / 2;
  return {points_[0] + m.mean, {std::cos(angle), std::sin(angle)}};
}

std::size_t endOfStraightRun(const std::vector<Eigen::Vector2d>& points, std::size_t begin) {
  const Eigen::Vector2d& first = points[begin];
  PossibleLines flat, steep;
  std::size_t end = begin;
  for (bool is_flat = true, is_steep = true; end < points.size(); ++end) {
    const Eigen::Vector2d p = points[end] - first;
    is_flat = is_flat && flat.add(p.x(), p.y());
    is_steep = is_steep && steep.add(p.y(), p.x());
    if (!is_flat && !is_steep) break;
  }
  return end;
}

}  // namespace facetloc::internal
