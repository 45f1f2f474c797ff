// SPDX-License-Identifier: BSD-3-Clause
#include "models/place_grid.h"

#include <facetloc/features/pose.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>

namespace facetloc::internal {
namespace {

constexpr double kNothing = std::numeric_limits<double>::infinity();
constexpr double kFlat = 0.15;         // unevenness of a floor [m]
constexpr double kStandingRoom = 1.5;  // above a floor, somewhere [m]
constexpr double kWalled = 0.5;        // share of the horizon that is known, indoors
constexpr double kGrounded = 0.25;     // known share of the surroundings below

/** Statistics of the rays around a place. */
class Surroundings {
public:
  Surroundings(const PlaceRules& rules, double above_floor) : rules_(rules), above_floor_(above_floor) {}

  void add(const Eigen::Vector3d& direction, double distance) {
    const bool known = distance < kNothing;
    nearest_ = std::min(nearest_, distance);
    if (std::abs(direction.z()) < std::sin(20 * kDegree)) ++level_, known_level_ += known;
    if (direction.z() > -std::sqrt(0.5)) return;
    ++below_, known_below_ += known;
    if (!known || distance * direction.head<2>().norm() > rules_.clearance) return;
    const double above = above_floor_ + distance * direction.z();  // height of the point above the floor
    obstacle_ |= above > kFlat;
    floor_ |= std::abs(above) <= kFlat;
  }
  bool isFree() const {
    if (rules_.beside > 0) return nearest_ >= rules_.clearance;
    return nearest_ >= rules_.clearance && known_level_ >= kWalled * level_ &&
           known_below_ >= kGrounded * below_ && (!rules_.stands || (floor_ && !obstacle_));
  }

private:
  const PlaceRules& rules_;
  double above_floor_;
  double nearest_ = kNothing;
  int level_ = 0, known_level_ = 0, below_ = 0, known_below_ = 0;
  bool obstacle_ = false, floor_ = false;
};

constexpr double kStep = 0.1;  // that can be taken from one place to the next [m]
constexpr double kBeside = 1;  // distance between an area and a place beside it [m]

/** Is the way from a place to the next one free? Also just above the floor, so that a window sill
 * blocks it. */
bool isOpen(const SpaceProbe& probe, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d step = to - from, down = -Eigen::Vector3d::UnitZ();
  const double below = std::min(probe.along(from, down), probe.along(to, down));
  const Eigen::Vector3d low = from + (below < kNothing ? std::max(0.0, below - kStep) : 0.0) * down;
  return probe.along(from, step.normalized()) > step.norm() &&
         probe.along(low, step.normalized()) > step.norm();
}

}  // namespace

PlaceGrid::PlaceGrid(const SpaceProbe& probe, const PlaceRules& rules, const ForEach& forEach)
    : probe_(probe), rules_(rules), bounds_(probe.bounds()) {
  const Eigen::AlignedBox3d surface = bounds_;
  const Eigen::Vector3d beside(rules.beside, rules.beside, 0);
  bounds_.min() -= beside, bounds_.max() += beside;
  const auto columnsAlong = [&](int axis) {
    return std::max(1, static_cast<int>(std::ceil(bounds_.sizes()[axis] / rules.step)));
  };
  nx_ = columnsAlong(0), ny_ = columnsAlong(1);
  std::vector<std::vector<double>> heights(columns());
  forEach(columns(), [&](std::size_t i) {
    Eigen::Vector3d top = position({static_cast<int>(i) % nx_, static_cast<int>(i) / nx_, -1});
    top.z() = surface.max().z() + 0.1;
    heights[i] = probe.heightsBelow(top, surface.min().z() - 0.1);
  });
  const double highest = *std::max_element(rules.heights.begin(), rules.heights.end());
  floors_ = floorLevels(heights, std::max(kStandingRoom, highest + rules.clearance));
}

Eigen::Vector3d PlaceGrid::position(const Cell& cell) const {
  const auto [x, y, layer] = cell;
  Eigen::Vector3d p(bounds_.min().x() + (x + 0.5) * rules_.step, bounds_.min().y() + (y + 0.5) * rules_.step,
                    0);
  if (layer >= 0) p.z() = floors_[static_cast<std::size_t>(layer) / rules_.heights.size()] + heightOf(layer);
  return p;
}

bool PlaceGrid::isFree(const Cell& cell) const {
  Surroundings surroundings(rules_, heightOf(cell[2]));
  probe_.around(position(cell), [&](const Eigen::Vector3d& direction, double distance) {
    surroundings.add(direction, distance);
  });
  return surroundings.isFree();
}

std::vector<PlaceGrid::Cell> PlaceGrid::freeCells(const ForEach& forEach) const {
  const auto cellOf = [&](std::size_t i) {
    const int layer = static_cast<int>(i % static_cast<std::size_t>(layers()));
    const int column = static_cast<int>(i / static_cast<std::size_t>(layers()));
    return Cell{column % nx_, column / nx_, layer};
  };
  std::vector<std::uint8_t> is_free(columns() * static_cast<std::size_t>(layers()));
  forEach(is_free.size(), [&](std::size_t i) { is_free[i] = isFree(cellOf(i)); });
  std::vector<Cell> cells;
  for (std::size_t i = 0; i < is_free.size(); ++i)
    if (is_free[i]) cells.push_back(cellOf(i));
  return cells;
}

Areas::Parts Areas::partsOf(const PlaceGrid& grid, const std::vector<PlaceGrid::Cell>& cells,
                            const Edges& edges) {
  Parts found;
  found.root.resize(cells.size());
  std::iota(found.root.begin(), found.root.end(), std::size_t{0});
  const auto rootOf = [&root = found.root](std::size_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for (const auto& [i, j] : edges) found.root[rootOf(j)] = rootOf(i);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    found.root[i] = rootOf(i);
    Part& part = found.parts[found.root[i]];
    const Eigen::Vector2d p = grid.position(cells[i]).head<2>();
    ++part.cells;
    part.layer = cells[i][2];
    part.extent.extend(p);
    part.places.push_back(p);
  }
  return found;
}

Areas::Areas(const PlaceGrid& grid, const std::vector<PlaceGrid::Cell>& cells, const SpaceProbe& probe) {
  std::map<PlaceGrid::Cell, std::size_t> index;
  for (std::size_t i = 0; i < cells.size(); ++i) index[cells[i]] = i;
  const auto beside = [&](std::size_t i, std::size_t axis, int by) -> std::optional<std::size_t> {
    PlaceGrid::Cell cell = cells[i];
    cell[axis] += by;
    const auto found = index.find(cell);
    return found == index.end() ? std::nullopt : std::optional(found->second);
  };
  std::vector<std::array<bool, 2>> open(cells.size());  // to the next cell along x and y
  for (std::size_t i = 0; i < cells.size(); ++i)
    for (const std::size_t axis : {0u, 1u})
      if (const auto next = beside(i, axis, 1))
        open[i][axis] = isOpen(probe, grid.position(cells[i]), grid.position(cells[*next]));
  const auto isWide = [&](std::size_t i, std::size_t axis) {  // a cell more to the left or to the right
    const std::size_t across = 1 - axis;
    const auto left = beside(i, across, 1), right = beside(i, across, -1);
    return (left && open[i][across] && open[*left][axis]) ||
           (right && open[*right][across] && open[*right][axis]);
  };
  Edges all, wide;
  for (std::size_t i = 0; i < cells.size(); ++i)
    for (const std::size_t axis : {0u, 1u}) {
      if (!open[i][axis]) continue;
      all.push_back({i, *beside(i, axis, 1)});
      if (isWide(i, axis)) wide.push_back(all.back());
    }
  areas_ = partsOf(grid, cells, all);
  rooms_ = partsOf(grid, cells, wide);
}

bool Areas::isOutdoors(std::size_t cell, double least_cells) const {
  const Part& own = rooms_.of(cell);
  bool surrounds = false;
  for (const auto& [root, other] : rooms_.parts) {
    if (root == rooms_.root[cell] || other.layer != own.layer ||
        static_cast<double>(other.cells) < least_cells)
      continue;
    const bool within = (other.extent.min().array() > own.extent.min().array()).all() &&
                        (other.extent.max().array() < own.extent.max().array()).all();
    if (!within) return false;
    surrounds = true;
  }
  return surrounds;
}

bool Areas::holdsAny(std::size_t cell, const std::vector<Eigen::Vector3d>& places) const {
  const std::vector<Eigen::Vector2d>& own = areas_.of(cell).places;
  return std::any_of(places.begin(), places.end(), [&](const Eigen::Vector3d& place) {
    return std::any_of(own.begin(), own.end(),
                       [&](const Eigen::Vector2d& p) { return (p - place.head<2>()).norm() <= kBeside; });
  });
}

}  // namespace facetloc::internal
