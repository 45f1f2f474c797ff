// SPDX-License-Identifier: BSD-3-Clause
#include "models/plan_outlines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace facetloc::internal {
namespace {

// To the right, up, left, down: each a quarter to the left of the one before.
constexpr std::array<std::array<int, 2>, 4> kSteps = {{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};

/** Edges of cells that have an occupied cell on the left and none on the right, by their first corner. */
class Edges {
public:
  explicit Edges(const OccupancyGrid& grid) : columns_(grid.width + 1) {
    leaving_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(grid.height + 1), 0);
    for (int row = 0; row < grid.height; ++row)
      for (int column = 0; column < grid.width; ++column) {
        if (!grid.isOccupied(column, row)) continue;
        if (!grid.isOccupied(column, row - 1)) add({column, row}, 0);
        if (!grid.isOccupied(column + 1, row)) add({column + 1, row}, 1);
        if (!grid.isOccupied(column, row + 1)) add({column + 1, row + 1}, 2);
        if (!grid.isOccupied(column - 1, row)) add({column, row + 1}, 3);
      }
  }

  template <class Visitor>
  void forEachLoop(const Visitor& visit) {
    for (std::size_t i = 0; i < leaving_.size(); ++i)
      while (leaving_[i] != 0)
        visit(takeLoop({static_cast<int>(i % static_cast<std::size_t>(columns_)),
                        static_cast<int>(i / static_cast<std::size_t>(columns_))}));
  }

private:
  std::uint8_t& at(const Eigen::Vector2i& corner) {
    return leaving_[static_cast<std::size_t>(corner.y()) * static_cast<std::size_t>(columns_) +
                    static_cast<std::size_t>(corner.x())];
  }
  void add(const Eigen::Vector2i& corner, int direction) {
    at(corner) |= static_cast<std::uint8_t>(1 << direction);
  }

  CellOutline takeLoop(const Eigen::Vector2i& first) {
    CellOutline loop;
    Eigen::Vector2i corner = first;
    int direction = 0;
    do {
      // To the right first, which goes on to a cell that only touches at this corner.
      for (const int turn : {3, 0, 1, 2}) {
        const int next = (direction + turn) % 4;
        if (!(at(corner) >> next & 1)) continue;
        direction = next;
        break;
      }
      at(corner) &= static_cast<std::uint8_t>(~(1 << direction));
      loop.push_back(corner);
      corner += Eigen::Vector2i(kSteps[static_cast<std::size_t>(direction)][0],
                                kSteps[static_cast<std::size_t>(direction)][1]);
    } while (corner != first);
    return loop;
  }

  int columns_;
  std::vector<std::uint8_t> leaving_;  // a bit for each direction
};

/** A line in the plane. */
struct FittedLine {
  Eigen::Vector2d through, along;  // a point of it, and its direction, of unit length

  Eigen::Vector2d nearest(const Eigen::Vector2d& p) const { return through + along.dot(p - through) * along; }
};

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

/** End of the longest run of points from begin on that one line passes within half a cell: measured along y
 * if the line is more along x, along x else. */
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

/** Total least squares of runs of points, each in constant time. */
class LineFits {
public:
  /** \param points the middles of the edges of cells along an outline [cells], which must outlive it */
  explicit LineFits(const std::vector<Eigen::Vector2d>& points) : points_(points), sums_(points.size() + 1) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector2d p = points[i] - points[0];
      const Sums& before = sums_[i];
      sums_[i + 1] = {before.first + p, before.xx + p.x() * p.x(), before.xy + p.x() * p.y(),
                      before.yy + p.y() * p.y()};
    }
  }
  /** Sum of the squared distances of points [begin, end) from their line. */
  double squares(std::size_t begin, std::size_t end) const {
    const Sums m = momentsOf(begin, end);
    return std::max(0.0, (m.xx + m.yy - std::hypot(m.xx - m.yy, 2 * m.xy)) / 2);
  }
  /** The line; of a single point, along the edge whose middle it is. */
  FittedLine line(std::size_t begin, std::size_t end) const {
    if (end - begin == 1) {
      // The middle of an edge along x has a whole y.
      const Eigen::Vector2d& p = points_[begin];
      return {p, p.y() == std::floor(p.y()) ? Eigen::Vector2d::UnitX() : Eigen::Vector2d::UnitY()};
    }
    const Sums m = momentsOf(begin, end);
    const double angle = std::atan2(2 * m.xy, m.xx - m.yy) / 2;
    return {points_[0] + m.first, {std::cos(angle), std::sin(angle)}};
  }

private:
  /** Sums over points and their squares; or their mean, and sums of squares about it. */
  struct Sums {
    Eigen::Vector2d first = Eigen::Vector2d::Zero();
    double xx = 0, xy = 0, yy = 0;
  };
  Sums momentsOf(std::size_t begin, std::size_t end) const {
    const Sums &a = sums_[begin], &b = sums_[end];
    const auto n = static_cast<double>(end - begin);
    const Eigen::Vector2d mean = (b.first - a.first) / n;
    return {mean, b.xx - a.xx - n * mean.x() * mean.x(), b.xy - a.xy - n * mean.x() * mean.y(),
            b.yy - a.yy - n * mean.y() * mean.y()};
  }

  const std::vector<Eigen::Vector2d>& points_;
  std::vector<Sums> sums_;  // sums over all points before
};

std::vector<Eigen::Vector2d> middlesOf(const CellOutline& outline, std::size_t first) {
  std::vector<Eigen::Vector2d> middles;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2i& a = outline[(first + i) % outline.size()];
    const Eigen::Vector2i& b = outline[(first + i + 1) % outline.size()];
    middles.push_back((a + b).cast<double>() / 2);
  }
  return middles;
}

/** Where runs of edges begin that are straight, as few as possible; the first at 0. */
std::vector<std::size_t> breaksOf(const std::vector<Eigen::Vector2d>& middles) {
  const std::size_t n = middles.size();
  const LineFits fits(middles);
  std::vector<double> cost(n + 1, std::numeric_limits<double>::infinity());
  std::vector<std::size_t> from(n + 1, 0);
  cost[0] = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t end = endOfStraightRun(middles, i);
    for (std::size_t j = i + 1; j <= end; ++j) {
      // Squares are at most a quarter of a cell each, so that all of them weigh less than one side.
      const double with_run = cost[i] + 1 + fits.squares(i, j) / static_cast<double>(n);
      if (with_run < cost[j]) cost[j] = with_run, from[j] = i;
    }
  }
  std::vector<std::size_t> breaks;
  for (std::size_t j = n; j > 0; j = from[j]) breaks.push_back(from[j]);
  std::reverse(breaks.begin(), breaks.end());
  return breaks;
}

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/** Joins two sides near the corner of a cell where the first ends: where they meet, or by a step. */
void join(const FittedLine& before, const FittedLine& after, const Eigen::Vector2d& corner,
          StraightOutline& out) {
  constexpr double kNear = 1.5;  // [cells]
  const double sine = cross(before.along, after.along);
  if (sine != 0) {
    const Eigen::Vector2d meeting =
        before.through + cross(after.through - before.through, after.along) / sine * before.along;
    if ((meeting - corner).norm() < kNear) return out.push_back(meeting);
  }
  out.push_back(before.nearest(corner));
  out.push_back(after.nearest(corner));
}

}  // namespace

std::vector<CellOutline> outlinesOf(const OccupancyGrid& grid) {
  std::vector<CellOutline> outlines;
  Edges(grid).forEachLoop([&outlines](CellOutline loop) { outlines.push_back(std::move(loop)); });
  return outlines;
}

StraightOutline straightened(const CellOutline& outline) {
  // The way round begins in the middle of a side; begun again where one ends, it has no side too many.
  const std::vector<std::size_t> once = breaksOf(middlesOf(outline, 0));
  const std::size_t first = once[once.size() / 2];
  const std::vector<Eigen::Vector2d> middles = middlesOf(outline, first);
  const std::vector<std::size_t> breaks = breaksOf(middles);
  const LineFits fits(middles);
  std::vector<FittedLine> sides;
  for (std::size_t k = 0; k < breaks.size(); ++k)
    sides.push_back(fits.line(breaks[k], k + 1 < breaks.size() ? breaks[k + 1] : middles.size()));
  StraightOutline out;
  for (std::size_t k = 0; k < sides.size(); ++k) {
    const Eigen::Vector2i& corner = outline[(first + breaks[k]) % outline.size()];
    join(sides[(k + sides.size() - 1) % sides.size()], sides[k], corner.cast<double>(), out);
  }
  return out;
}

}  // namespace facetloc::internal
