// SPDX-License-Identifier: BSD-3-Clause
#include "models/free_places.h"

#include "models/cube_view.h"
#include "models/place_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace facetloc::internal {
namespace {

constexpr double kNothing = std::numeric_limits<double>::infinity();
constexpr double kFlat = 0.15;        // unevenness of a floor [m]
constexpr double kStorey = 1.8;       // least distance between two floors [m]
constexpr double kLevelShare = 0.25;  // least share of a floor in the columns of the commonest level
constexpr double kLeastArea = 2;      // least area of connected places [m^2]

}  // namespace

double SpaceProbe::along(const Eigen::Vector3d& from, const Eigen::Vector3d& direction) const {
  return distanceAlong(surface_, T_w_up_, from, direction);
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
  lookAround(surface_, T_w_up_, position, kSide,
             [&](const Eigen::Isometry3d& T_up_c, const DepthImage& face) {
               for (int v = 0; v < kSide; ++v)
                 for (int u = 0; u < kSide; ++u) {
                   const Eigen::Vector3d ray = T_up_c.linear() * face.camera.ray(u, v);
                   const float z = face.at(u, v);
                   take(ray.normalized(), isMeasured(z) ? z * ray.norm() : kNothing);
                 }
             });
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
  const std::vector<PlaceGrid::Cell> cells = grid.freeCells(forEach);
  FreePlaces found;
  if (rules.beside > 0) {
    for (const PlaceGrid::Cell& cell : cells) found.positions.push_back(grid.position(cell));
    return found;
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
  return found;
}

}  // namespace facetloc::internal
