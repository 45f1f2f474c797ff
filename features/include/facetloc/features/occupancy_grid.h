// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace facetloc {

/** \brief Floor plan of a 2-D robot: occupied, free and unknown square cells, as in
 * nav_msgs/OccupancyGrid. Row-major; cell (0, 0) is at the origin, columns run along the grid's x axis, rows
 * along its y axis. */
struct OccupancyGrid {
  static constexpr std::int8_t kUnknown = -1;
  static constexpr std::int8_t kFree = 0;
  static constexpr std::int8_t kOccupied = 100;

  int width = 0;          ///< [cells]
  int height = 0;         ///< [cells]
  double resolution = 0;  ///< side of a cell [m]
  /** \brief Outer corner of cell (0, 0) in the world, and the heading of the rows. */
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();  ///< [m]
  double yaw = 0;                                    ///< [rad]
  std::vector<std::int8_t> cells;                    ///< probability of occupation [%], or kUnknown

  /** \brief Cells of one value. Throws std::invalid_argument unless all sizes are positive and finite. */
  static OccupancyGrid filled(int width, int height, double resolution, const Eigen::Vector2d& origin,
                              std::int8_t value);

  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column);
  }
  bool contains(int column, int row) const {
    return column >= 0 && row >= 0 && column < width && row < height;
  }
  std::int8_t at(int column, int row) const { return cells[index(column, row)]; }
  /** \brief More likely occupied than the threshold that ROS uses, 65 %; false outside of the grid. */
  bool isOccupied(int column, int row) const;
  /** \brief Known, and less likely occupied than 25 %; false outside of the grid. */
  bool isFree(int column, int row) const;

  /** \brief Pose of the grid's axes, in metres, in the world. */
  Eigen::Isometry2d T_w_grid() const;
  /** \brief Middle of a cell in the world [m]. */
  Eigen::Vector2d centre(int column, int row) const;
  /** \brief Column and row, with fractions: cell (i, j) covers [i, i + 1) x [j, j + 1). */
  Eigen::Vector2d cellOf(const Eigen::Vector2d& world) const;
};

}  // namespace facetloc
