// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "models/free_places.h"

#include <array>
#include <map>
#include <vector>

namespace facetloc::internal {

/** \brief Positions in columns over a surface, at heights above its floors. */
class PlaceGrid {
public:
  /** \brief Column along x and y, and layer: one for each floor and height. */
  using Cell = std::array<int, 3>;

  /** \brief \param probe, rules are borrowed */
  PlaceGrid(const SpaceProbe& probe, const PlaceRules& rules, const ForEach& forEach);

  Eigen::Vector3d position(const Cell& cell) const;
  /** \brief The possible positions of a camera, by their surroundings alone. */
  std::vector<Cell> freeCells(const ForEach& forEach) const;

private:
  std::size_t columns() const { return static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_); }
  int layers() const { return static_cast<int>(floors_.size() * rules_.heights.size()); }
  double heightOf(int layer) const {
    return rules_.heights[static_cast<std::size_t>(layer) % rules_.heights.size()];
  }
  bool isFree(const Cell& cell) const;

  const SpaceProbe& probe_;
  const PlaceRules& rules_;
  Eigen::AlignedBox3d bounds_;  // box of the surface and its surroundings
  int nx_, ny_;
  std::vector<double> floors_;
};

/** \brief Cells that somebody can go between are one area; without ways as narrow as a door, it falls into
 * rooms.
 */
class Areas {
public:
  /** \brief \param cells are borrowed */
  Areas(const PlaceGrid& grid, const std::vector<PlaceGrid::Cell>& cells, const SpaceProbe& probe);

  bool isLarge(std::size_t cell, double least_cells) const {
    return static_cast<double>(areas_.of(cell).cells) >= least_cells;
  }
  /** \brief Does its room surround all large ones of its layer, of which there is another? */
  bool isOutdoors(std::size_t cell, double least_cells) const;
  /** \brief Is one of these places in its area, or less than 1 m beside it? */
  bool holdsAny(std::size_t cell, const std::vector<Eigen::Vector3d>& places) const;

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
  static Parts partsOf(const PlaceGrid& grid, const std::vector<PlaceGrid::Cell>& cells, const Edges& edges);

  Parts areas_, rooms_;
};

}  // namespace facetloc::internal
