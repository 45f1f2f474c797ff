// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>

namespace facetloc {

/** \brief Reach of the holes of a depth image that was aligned to a finer one, which leaves pixels between
 * those that it fills: how far from a hole the measured pixels around it are, on all its sides [px]. 0 for
 * images without such a grid of holes: those of which fewer than half as many pixels are holes between
 * measured ones as are measured. */
int holeGridReach(const DepthImage& image);

/** \brief Fills the grid of holes: a hole takes the mean inverse depth of the measured pixels around it if
 * these are of one surface, or else the depth of the nearest one. Larger holes stay, and an image without a
 * grid of holes stays as it is. */
void fillHoleGrid(DepthImage& image);

}  // namespace facetloc
