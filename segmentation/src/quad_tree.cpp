// SPDX-License-Identifier: BSD-3-Clause
#include "quad_tree.h"

#include <algorithm>

namespace facetloc::internal {

QuadTree::QuadTree(double tolerance) : max_square_(tolerance * tolerance) {}

void QuadTree::compute(const DisparityImage& image) {
  leaves_.clear();
  int columns = (image.camera.width + kSmallestCell - 1) / kSmallestCell;
  int rows = (image.camera.height + kSmallestCell - 1) / kSmallestCell;
  for (Level& level : levels_) {
    level.columns = columns, level.rows = rows;
    level.cells.resize(static_cast<std::size_t>(columns) * rows);
    columns /= 2, rows /= 2;  // cells of which parts are missing are never flat
  }
  leaf_of_cell_.assign(levels_[0].cells.size(), -1);
  leaves_.reserve(levels_[0].cells.size());

  const CellBounds bounds{kMinFill, static_cast<float>(max_square_)};
  for (int row = 0; row < levels_[0].rows; ++row)
    fitSmallestCells(image, row, bounds, levels_[0].cells.data() + std::size_t(row) * levels_[0].columns);
  for (int level = 1; level < kLevels; ++level) joinParts(levels_[level - 1], levels_[level]);

  for (int level = kLevels - 1; level >= 0; --level) collectLeaves(level);
}

void QuadTree::joinParts(const Level& parts, Level& level) const {
  for (int row = 0; row < level.rows; ++row)
    for (int column = 0; column < level.columns; ++column) {
      const Cell* upper = &parts.cells[std::size_t(2 * row) * parts.columns + 2 * column];
      const Cell* lower = upper + parts.columns;
      join({upper, upper + 1, lower, lower + 1}, level.cells[std::size_t(row) * level.columns + column]);
    }
}

// Four parts are one if merging would make one region of them (METHOD 4.2).
void QuadTree::join(const std::array<const Cell*, 4>& parts, Cell& whole) const {
  whole.flat = std::all_of(parts.begin(), parts.end(), [](const Cell* part) { return part->flat; });
  if (!whole.flat) return;
  whole.moments = parts[0]->moments;
  double sse_of_parts = parts[0]->sse, smallest = parts[0]->moments.n;
  for (std::size_t i = 1; i < parts.size(); ++i) {
    whole.moments += parts[i]->moments;
    sse_of_parts += parts[i]->sse;
    smallest = std::min(smallest, parts[i]->moments.n);
  }
  const double sse = whole.moments.fit().sse;
  whole.sse = static_cast<float>(sse);
  whole.flat =
      sse <= whole.moments.n * max_square_ && sse - sse_of_parts <= std::max(3.0, smallest) * max_square_;
}

// The flat cells of a level that are not part of a larger one.
void QuadTree::collectLeaves(int level) {
  const Level& own = levels_[level];
  const Level* const above = level + 1 < kLevels ? &levels_[level + 1] : nullptr;
  const auto is_part = [above](int column, int row) {
    return above && column / 2 < above->columns && row / 2 < above->rows &&
           above->cells[std::size_t(row / 2) * above->columns + column / 2].flat;
  };
  for (int row = 0; row < own.rows; ++row)
    for (int column = 0; column < own.columns; ++column)
      if (own.cells[std::size_t(row) * own.columns + column].flat && !is_part(column, row))
        addLeaf(level, column, row);
}

void QuadTree::addLeaf(int level, int column, int row) {
  const int cells = 1 << level, size = kSmallestCell * cells;
  const int leaf = static_cast<int>(leaves_.size());
  leaves_.push_back({column * size, row * size, size,
                     levels_[level].cells[std::size_t(row) * levels_[level].columns + column].moments});
  for (int y = row * cells; y < (row + 1) * cells; ++y)
    std::fill_n(leaf_of_cell_.begin() + std::size_t(y) * columns() + column * cells, cells, leaf);
}

}  // namespace facetloc::internal
