// SPDX-License-Identifier: BSD-3-Clause
#include "models/free_places.h"

#include <facetloc/features/pose.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <optional>

namespace facetloc::internal {
namespace {

constexpr double kNothing = std::numeric_limits<double>::infinity();
constexpr double kFlat = 0.15;            // unevenness of a floor [m]
constexpr double kStorey = 1.8;           // least distance between two floors [m]
constexpr double kLevelShare = 0.25;      // least share of a floor in the columns of the commonest level
constexpr double kLeastArea = 2;          // least area of connected places [m^2]
constexpr double kStep = 0.1;             // that can be taken from one place to the next [m]
constexpr double kBeside = 1;             // distance between an area and a place beside it [m]
constexpr double kStandingRoom = 1.5;     // above a floor, somewhere [m]
constexpr double kWalled = 0.5;           // share of the horizon that is known, indoors
constexpr double kGrounded = 0.25;        // known share of the surroundings below
constexpr std::size_t kWithOutdoors = 5;  // positions to each one that those outdoors may leave

/** A camera that looks along a direction. */
Eigen::Isometry3d lookingAlong(const Eigen::Vector3d& from, const Eigen::Vector3d& direction) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = rotationBetween(Eigen::Vector3d::UnitZ(), direction);
  T.translation() = from;
  return T;
}

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

/** Is the way from a place to the next one free? Also just above the floor, so that a window sill
 * blocks it. */
bool isOpen(const SpaceProbe& probe, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d step = to - from, down = -Eigen::Vector3d::UnitZ();
  const double below = std::min(probe.along(from, down), probe.along(to, down));
  const Eigen::Vector3d low = from + (below < kNothing ? std::max(0.0, below - kStep) : 0.0) * down;
  return probe.along(from, step.normalized()) > step.norm() &&
         probe.along(low, step.normalized()) > step.norm();
}

/** Positions in columns over a surface, at heights above its floors. */
class PlaceGrid {
public:
  /** Column along x and y, and layer: one for each floor and height. */
  using Cell = std::array<int, 3>;

  /** \param probe, rules are borrowed */
  PlaceGrid(const SpaceProbe& probe, const PlaceRules& rules, const ForEach& forEach)
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

  Eigen::Vector3d position(const Cell& cell) const {
    const auto [x, y, layer] = cell;
    Eigen::Vector3d p(bounds_.min().x() + (x + 0.5) * rules_.step,
                      bounds_.min().y() + (y + 0.5) * rules_.step, 0);
    if (layer >= 0)
      p.z() = floors_[static_cast<std::size_t>(layer) / rules_.heights.size()] + heightOf(layer);
    return p;
  }

  /** The possible positions of a camera, by their surroundings alone. */
  std::vector<Cell> freeCells(const ForEach& forEach) const {
    std::vector<std::uint8_t> is_free(columns() * static_cast<std::size_t>(layers()));
    forEach(is_free.size(), [&](std::size_t i) { is_free[i] = isFree(cellOf(i)); });
    std::vector<Cell> cells;
    for (std::size_t i = 0; i < is_free.size(); ++i)
      if (is_free[i]) cells.push_back(cellOf(i));
    return cells;
  }

  /** Number of free cells, estimated; 0 where freeCells() is quick. */
  std::size_t estimatedFree(const ForEach& forEach) const {
    constexpr std::size_t kSamples = 4000, kFew = 20;  // a sample is a twentieth of the work at most
    const std::size_t all = columns() * static_cast<std::size_t>(layers());
    if (all < kFew * kSamples) return 0;
    std::vector<std::uint8_t> is_free(kSamples);
    forEach(kSamples, [&](std::size_t i) {
      const double golden = 0.6180339887498949 * static_cast<double>(i);  // spreads evenly, whatever the rows
      is_free[i] =
          isFree(cellOf(static_cast<std::size_t>((golden - std::floor(golden)) * static_cast<double>(all))));
    });
    return all / kSamples * static_cast<std::size_t>(std::count(is_free.begin(), is_free.end(), 1));
  }

private:
  std::size_t columns() const { return static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_); }
  int layers() const { return static_cast<int>(floors_.size() * rules_.heights.size()); }
  double heightOf(int layer) const {
    return rules_.heights[static_cast<std::size_t>(layer) % rules_.heights.size()];
  }
  Cell cellOf(std::size_t i) const {
    const int layer = static_cast<int>(i % static_cast<std::size_t>(layers()));
    const int column = static_cast<int>(i / static_cast<std::size_t>(layers()));
    return {column % nx_, column / nx_, layer};
  }
  bool isFree(const Cell& cell) const {
    constexpr int kSide = 24;  // [px] of each face of a cube
    const Eigen::Vector3d place = position(cell);
    if (!probe_.isFree(place)) return false;
    Surroundings surroundings(rules_, heightOf(cell[2]));
    probe_.look(place, kSide, [&](const Eigen::Isometry3d& T_up_c, const DepthImage& face) {
      for (int v = 0; v < kSide; ++v)
        for (int u = 0; u < kSide; ++u) {
          const Eigen::Vector3d ray = T_up_c.linear() * face.camera.ray(u, v);
          const float z = face.at(u, v);
          surroundings.add(ray.normalized(), isMeasured(z) ? z * ray.norm() : kNothing);
        }
    });
    return surroundings.isFree();
  }

  const SpaceProbe& probe_;
  const PlaceRules& rules_;
  Eigen::AlignedBox3d bounds_;  // box of the surface and its surroundings
  int nx_, ny_;
  std::vector<double> floors_;
};

/** Cells that somebody can go between are one area; without ways as narrow as a door, it falls into rooms. */
class Areas {
public:
  /** \param cells are borrowed */
  Areas(const PlaceGrid& grid, const std::vector<PlaceGrid::Cell>& cells, const SpaceProbe& probe) {
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

  bool isLarge(std::size_t cell, double least_cells) const {
    return static_cast<double>(areas_.of(cell).cells) >= least_cells;
  }
  /** Does its room surround all large ones of its layer, of which there is another? */
  bool isOutdoors(std::size_t cell, double least_cells) const {
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

  /** Is one of these places in its area, or less than 1 m beside it? */
  bool holdsAny(std::size_t cell, const std::vector<Eigen::Vector3d>& places) const {
    const std::vector<Eigen::Vector2d>& own = areas_.of(cell).places;
    return std::any_of(places.begin(), places.end(), [&](const Eigen::Vector3d& place) {
      return std::any_of(own.begin(), own.end(),
                         [&](const Eigen::Vector2d& p) { return (p - place.head<2>()).norm() <= kBeside; });
    });
  }

private:
  struct Part {
    std::size_t cells = 0;
    int layer = 0;
    Eigen::AlignedBox2d extent;
    std::vector<Eigen::Vector2d> places;
  };
  /** Connected cells. */
  struct Parts {
    std::vector<std::size_t> root;  // for each cell the representative of its connected part
    std::map<std::size_t, Part> parts;
    const Part& of(std::size_t cell) const { return parts.at(root[cell]); }
  };
  using Edges = std::vector<std::array<std::size_t, 2>>;

  static Parts partsOf(const PlaceGrid& grid, const std::vector<PlaceGrid::Cell>& cells, const Edges& edges) {
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

  Parts areas_, rooms_;
};

}  // namespace

double SpaceProbe::along(const Eigen::Vector3d& from, const Eigen::Vector3d& direction) const {
  constexpr Intrinsics kRay{1, 1, 1, 1, 0, 0};
  const float z = surface_.render(kRay, T_w_up_ * lookingAlong(from, direction)).at(0, 0);
  return isMeasured(z) ? z : kNothing;
}

std::vector<double> SpaceProbe::heightsBelow(Eigen::Vector3d from, double lowest) const {
  constexpr double kThickness = 0.02;  // [m] nearer surfaces are one
  constexpr std::size_t kMost = 100;
  std::vector<double> heights;
  while (from.z() > lowest && heights.size() < kMost) {
    const double distance = along(from, -Eigen::Vector3d::UnitZ());
    if (distance == kNothing) break;
    heights.push_back(from.z() - distance);
    from.z() -= distance + kThickness;
  }
  return heights;
}

void SpaceProbe::look(const Eigen::Vector3d& position, int side,
                      const std::function<void(const Eigen::Isometry3d&, const DepthImage&)>& take) const {
  const double half = side / 2.0;
  const Intrinsics face{side, side, half, half, half - 0.5, half - 0.5};
  for (const int axis : {0, 1, 2})
    for (const double sign : {-1.0, 1.0}) {
      const Eigen::Isometry3d T_up_c = lookingAlong(position, sign * Eigen::Vector3d::Unit(axis));
      take(T_up_c, surface_.render(face, T_w_up_ * T_up_c));
    }
}

Eigen::AlignedBox3d SpaceProbe::bounds() const {
  const Eigen::AlignedBox3d in_world = surface_.bounds();
  Eigen::AlignedBox3d bounds;
  if (in_world.isEmpty()) return bounds;
  for (int i = 0; i < 8; ++i)
    bounds.extend(T_w_up_.inverse() * in_world.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i)));
  return bounds;
}

std::vector<double> floorLevels(const std::vector<std::vector<double>>& columns, double standing_room) {
  std::vector<double> heights;  // heights of all columns with room above
  for (const std::vector<double>& column : columns)
    for (std::size_t i = 0; i < column.size(); ++i)
      if (i == 0 || column[i - 1] - column[i] >= standing_room) heights.push_back(column[i]);
  std::sort(heights.begin(), heights.end());
  const auto within = [&](double low, double high) {
    return std::pair(std::lower_bound(heights.begin(), heights.end(), low),
                     std::upper_bound(heights.begin(), heights.end(), high));
  };
  const auto near = [&](double z) { return within(z - kFlat / 2, z + kFlat / 2); };
  std::ptrdiff_t most = 0;
  for (const double z : heights) most = std::max(most, near(z).second - near(z).first);
  std::vector<double> levels;
  for (const double z : heights) {
    const auto [first, last] = near(z);
    const auto count = last - first;
    if (static_cast<double>(count) < kLevelShare * static_cast<double>(most)) continue;
    if (!levels.empty() && z - levels.back() < kStorey) continue;
    // The commonest of this level, not its lower edge.
    double level = z;
    std::ptrdiff_t best = count;
    for (auto it = first; it != within(z, z + kFlat).second; ++it)
      if (const auto n = near(*it).second - near(*it).first; n > best) best = n, level = *it;
    const auto [from, to] = near(level);
    levels.push_back(std::accumulate(from, to, 0.0) / static_cast<double>(to - from));
  }
  return levels;
}

FreePlaces freePlaces(const SpaceProbe& probe, const PlaceRules& rules, const ForEach& forEach) {
  if (probe.bounds().isEmpty() || rules.heights.empty()) return {};
  const PlaceGrid grid(probe, rules, forEach);
  FreePlaces found;
  if (rules.most > 0) {
    const std::size_t estimated = grid.estimatedFree(forEach);
    if (estimated > kWithOutdoors * rules.most) {
      found.too_many = estimated;
      return found;
    }
  }
  const auto finish = [&] {
    if (rules.most > 0 && found.positions.size() > rules.most) {
      found.too_many = found.positions.size();
      found.positions.clear();
    }
    return std::move(found);
  };
  const std::vector<PlaceGrid::Cell> cells = grid.freeCells(forEach);
  if (rules.beside > 0) {
    for (const PlaceGrid::Cell& cell : cells) found.positions.push_back(grid.position(cell));
    return finish();
  }
  const Areas areas(grid, cells, probe);
  const double least = kLeastArea / (rules.step * rules.step);  // area as a number of cells
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (!areas.isLarge(i, least)) continue;
    const bool kept = rules.inside.empty() ? !areas.isOutdoors(i, least) : areas.holdsAny(i, rules.inside);
    if (kept)
      found.positions.push_back(grid.position(cells[i]));
    else
      ++found.outdoors;
  }
  return finish();
}

}  // namespace facetloc::internal
