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

namespace facetloc::internal {
namespace {

constexpr double kNothing = std::numeric_limits<double>::infinity();
constexpr double kFlat = 0.15;         // by which a floor may be uneven [m]
constexpr double kStandingRoom = 1.5;  // above a floor, somewhere [m]
constexpr double kStorey = 1.8;        // from a floor to the next one, at least [m]
constexpr double kLevelShare = 0.25;   // of the columns of the commonest level that a floor has at least
constexpr double kWalled =
    0.5;  // share of the horizon that is known, indoors: in front of a house it is half
constexpr double kGrounded = 0.25;  // share of what is below that is known
constexpr double kLeastArea = 2;    // of connected places [m^2]

/** A camera that looks along a direction. */
Eigen::Isometry3d lookingAlong(const Eigen::Vector3d& from, const Eigen::Vector3d& direction) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = rotationBetween(Eigen::Vector3d::UnitZ(), direction);
  T.translation() = from;
  return T;
}

/** A place of the grid: column, row and layer. */
using Cell = std::array<int, 3>;

/** What the rays around a place say of it. */
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
    const double above = above_floor_ + distance * direction.z();  // of what stands there
    obstacle_ |= above > kFlat;
    floor_ |= std::abs(above) <= kFlat;
  }
  bool isFree() const {
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

/** Numbers of connected places: cells next to each other that see each other. */
std::vector<std::size_t> componentsOf(const std::map<Cell, std::size_t>& cells,
                                      const std::vector<Eigen::Vector3d>& positions,
                                      const SpaceProbe& probe) {
  std::vector<std::size_t> parent(positions.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root = [&](std::size_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const auto& [cell, place] : cells)
    for (const int axis : {0, 1}) {
      Cell beside = cell;
      ++beside[static_cast<std::size_t>(axis)];
      const auto found = cells.find(beside);
      if (found == cells.end()) continue;
      const Eigen::Vector3d step = positions[found->second] - positions[place];
      if (probe.along(positions[place], step.normalized()) > step.norm())
        parent[root(found->second)] = root(place);
    }
  for (std::size_t i = 0; i < parent.size(); ++i) parent[i] = root(i);
  return parent;
}

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

void SpaceProbe::around(const Eigen::Vector3d& position,
                        const std::function<void(const Eigen::Vector3d&, double)>& take) const {
  constexpr int kSide = 24;  // [px] of each face of a cube
  constexpr Intrinsics kFace{kSide, kSide, kSide / 2.0, kSide / 2.0, (kSide - 1) / 2.0, (kSide - 1) / 2.0};
  for (const int axis : {0, 1, 2})
    for (const double sign : {-1.0, 1.0}) {
      const Eigen::Isometry3d T_up_c = lookingAlong(position, sign * Eigen::Vector3d::Unit(axis));
      const DepthImage face = surface_.render(kFace, T_w_up_ * T_up_c);
      for (int v = 0; v < kSide; ++v)
        for (int u = 0; u < kSide; ++u) {
          const Eigen::Vector3d ray = T_up_c.linear() * kFace.ray(u, v);
          const float z = face.at(u, v);
          take(ray.normalized(), isMeasured(z) ? z * ray.norm() : kNothing);
        }
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
  std::vector<double> heights;  // of all that has room above
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

std::vector<Eigen::Vector3d>
freePlaces(const SpaceProbe& probe, const PlaceRules& rules,
           const std::function<void(std::size_t, const std::function<void(std::size_t)>&)>& inParallel) {
  const Eigen::AlignedBox3d bounds = probe.bounds();
  if (bounds.isEmpty() || rules.heights.empty()) return {};
  const auto columns_along = [&](int axis) {
    return static_cast<int>(std::ceil(bounds.sizes()[axis] / rules.step));
  };
  const int nx = std::max(1, columns_along(0)), ny = std::max(1, columns_along(1));
  const auto columnAt = [&](std::size_t i) {
    const int x = static_cast<int>(i) % nx, y = static_cast<int>(i) / nx;
    return Eigen::Vector3d(bounds.min().x() + (x + 0.5) * rules.step,
                           bounds.min().y() + (y + 0.5) * rules.step, bounds.max().z() + 0.1);
  };
  const std::size_t columns = static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny);
  std::vector<std::vector<double>> heights(columns);
  inParallel(columns,
             [&](std::size_t i) { heights[i] = probe.heightsBelow(columnAt(i), bounds.min().z() - 0.1); });
  const double highest = *std::max_element(rules.heights.begin(), rules.heights.end());
  const std::vector<double> floors = floorLevels(heights, std::max(kStandingRoom, highest + rules.clearance));

  const std::size_t layers = floors.size() * rules.heights.size();
  std::vector<std::uint8_t> is_free(columns * layers);
  const auto positionOf = [&](std::size_t i, std::size_t layer) {
    Eigen::Vector3d position = columnAt(i);
    position.z() = floors[layer / rules.heights.size()] + rules.heights[layer % rules.heights.size()];
    return position;
  };
  inParallel(columns, [&](std::size_t i) {
    for (std::size_t layer = 0; layer < layers; ++layer) {
      Surroundings surroundings(rules, rules.heights[layer % rules.heights.size()]);
      probe.around(positionOf(i, layer), [&](const Eigen::Vector3d& direction, double distance) {
        surroundings.add(direction, distance);
      });
      is_free[i * layers + layer] = surroundings.isFree();
    }
  });

  std::vector<Eigen::Vector3d> positions;
  std::map<Cell, std::size_t> cells;
  for (std::size_t i = 0; i < columns; ++i)
    for (std::size_t layer = 0; layer < layers; ++layer)
      if (is_free[i * layers + layer]) {
        cells[{static_cast<int>(i) % nx, static_cast<int>(i) / nx, static_cast<int>(layer)}] =
            positions.size();
        positions.push_back(positionOf(i, layer));
      }
  const std::vector<std::size_t> component = componentsOf(cells, positions, probe);
  std::map<std::size_t, int> sizes;
  for (const std::size_t c : component) ++sizes[c];
  std::vector<Eigen::Vector3d> connected;
  for (std::size_t i = 0; i < positions.size(); ++i)
    if (sizes[component[i]] * rules.step * rules.step >= kLeastArea) connected.push_back(positions[i]);
  return connected;
}

}  // namespace facetloc::internal
