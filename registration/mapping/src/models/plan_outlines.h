// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/occupancy_grid.h>

#include <Eigen/Core>

#include <vector>

namespace facetloc::internal {

/** \brief Closed way along the edges of cells, through their corners [cells]; the first corner is not
 * repeated. */
using CellOutline = std::vector<Eigen::Vector2i>;
/** \brief Corners of a polygon [cells]. */
using StraightOutline = std::vector<Eigen::Vector2d>;

/** \brief The outlines of the occupied cells of a grid, these on the left. Cells that touch at a corner are
 * one thing. */
std::vector<CellOutline> outlinesOf(const OccupancyGrid& grid);

/** \brief The polygon of fewest sides such that each edge of a cell is within half a cell of its side,
 * measured along the axis that is more across the side; of these, about the one with the least squares. */
StraightOutline straightened(const CellOutline& outline);

}  // namespace facetloc::internal
