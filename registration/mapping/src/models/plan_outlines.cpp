// SPDX-License-Identifier: BSD-3-Clause
#include "models/plan_outlines.h"

#include "models/straight_run.h"

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
