// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/occupancy_grid.h>

#include <cmath>
#include <stdexcept>

namespace facetloc {
namespace {

constexpr int kOccupiedFrom = 65, kFreeBelow = 25;  // [%]

}  // namespace

OccupancyGrid OccupancyGrid::filled(int width, int height, double resolution, const Eigen::Vector2d& origin,
                                    std::int8_t value) {
  if (width < 1 || height < 1 || !(resolution > 0) || !std::isfinite(resolution) || !origin.allFinite())
    throw std::invalid_argument("an occupancy grid needs cells of a positive size, and a finite origin");
  OccupancyGrid grid;
  grid.width = width, grid.height = height, grid.resolution = resolution, grid.origin = origin;
  grid.cells.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), value);
  return grid;
}

bool OccupancyGrid::isOccupied(int column, int row) const {
  return contains(column, row) && at(column, row) >= kOccupiedFrom;
}

bool OccupancyGrid::isFree(int column, int row) const {
  return contains(column, row) && at(column, row) >= 0 && at(column, row) < kFreeBelow;
}

Eigen::Isometry2d OccupancyGrid::T_w_grid() const {
  return Eigen::Translation2d(origin) * Eigen::Rotation2Dd(yaw);
}

Eigen::Vector2d OccupancyGrid::centre(int column, int row) const {
  return T_w_grid() * (resolution * Eigen::Vector2d(column + 0.5, row + 0.5));
}

Eigen::Vector2d OccupancyGrid::cellOf(const Eigen::Vector2d& world) const {
  return T_w_grid().inverse() * world / resolution;
}

}  // namespace facetloc
