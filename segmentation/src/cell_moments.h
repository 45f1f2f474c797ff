// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "disparity_image.h"

#include <facetloc/features/plane_fit.h>

namespace facetloc::internal {

/** \brief Side of the smallest cells of an image [px]; those at its right and lower border may be cut off. */
constexpr int kSmallestCell = 4;

/** \brief A square of pixels as the fit of a plane sees it. */
struct Cell {
  PlaneMoments moments;  ///< moments of its measured pixels in (u, v, disparity); only if it is flat
  float sse = 0;         ///< sum of squared residuals to its own plane; only if it is flat
  bool flat = false;
};

/** \brief When a smallest cell is flat (METHOD 4.1). */
struct CellBounds {
  double min_fill = 0;   ///< least share of measured pixels
  float max_square = 0;  ///< largest mean square residual to its own plane [noise variance]
};

/** \brief The smallest cells of a row of them, from left to right.
 *
 * Sums over fully measured cells are taken in single precision, relative to a pixel of the cell, which loses
 * nothing where a cell is flat; all else in double precision. The bits are the same on every processor.
 * \param row counts from the top \param cells ceil(width / 4) of them; cells that are not flat keep their
 * moments */
void fitSmallestCells(const DisparityImage& image, int row, const CellBounds& bounds, Cell* cells);

}  // namespace facetloc::internal
