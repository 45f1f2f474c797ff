// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cell_moments.h"

#include <facetloc/segmentation/plane_segmenter.h>

#include <array>
#include <cstdint>
#include <vector>

namespace facetloc::internal {

/** \brief Split of a disparity image into flat squares of 4 to 64 px, whose moments are known (METHOD 4).
 *
 * Moments are summed from the smallest cells upwards: four flat cells that are one plane are a flat cell of
 * twice the side. Leaves are the largest flat cells. They do not overlap; pixels between them belong to
 * no leaf. */
class QuadTree {
public:
  struct Leaf {
    std::int32_t u = 0, v = 0;  ///< its first pixel
    std::int32_t size = 0;      ///< its side [px]; the image may end before
    PlaneMoments moments;       ///< moments of its measured pixels in (u, v, disparity)
  };

  /** \param tolerance largest residual and displacement of one plane, those of merging [noise std] */
  explicit QuadTree(double tolerance = MergeParams{}.tolerance);

  void compute(const DisparityImage& image);

  const std::vector<Leaf>& leaves() const { return leaves_; }
  /** \brief Size of the image in smallest cells. */
  int columns() const { return levels_[0].columns; }
  int rows() const { return levels_[0].rows; }
  /** \brief The leaf of each smallest cell, row by row; -1 = none. */
  const std::vector<std::int32_t>& leafOfCell() const { return leaf_of_cell_; }
  /** \brief Moments of a smallest cell that has a leaf. */
  const PlaneMoments& momentsOfCell(std::size_t cell) const { return levels_[0].cells[cell].moments; }

  /** \brief Calls a function with any two leaves that have a side, or a part of one, in common, once. */
  template <class Function>
  void forEachCommonSide(const Function& function) const {
    for (std::size_t i = 0; i < leaves_.size(); ++i) {
      const Leaf& leaf = leaves_[i];
      const int column = leaf.u / kSmallestCell, row = leaf.v / kSmallestCell,
                cells = leaf.size / kSmallestCell;
      const int a = static_cast<int>(i);
      // To the right and below; smaller neighbours come one after the other, larger ones as often as cells.
      const auto callFor = [&](int first, int step) {
        for (int k = 0, last = -1; k < cells; ++k) {
          const int b = leaf_of_cell_[std::size_t(first + k * step)];
          if (b >= 0 && b != last) function(a, b);
          last = b;
        }
      };
      if (column + cells < columns()) callFor(row * columns() + column + cells, columns());
      if (row + cells < rows()) callFor((row + cells) * columns() + column, 1);
    }
  }

private:
  static constexpr int kLevels = 5;  // 4, 8, 16, 32 and 64 px

  struct Level {
    int columns = 0, rows = 0;
    std::vector<Cell> cells;
  };
  void joinParts(const Level& parts, Level& level) const;
  void join(const std::array<const Cell*, 4>& parts, Cell& whole) const;
  void collectLeaves(int level);
  void addLeaf(int level, int column, int row);

  double max_square_;
  std::array<Level, kLevels> levels_;
  std::vector<Leaf> leaves_;
  std::vector<std::int32_t> leaf_of_cell_;
};

}  // namespace facetloc::internal
