// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/lanes.h"
#include "shortlist/place_descriptor.h"

namespace facetloc::internal {

/** \brief Which of eight walls overlap with another one in height, or nearly: parts of one wall may. */
FACETLOC_ALWAYS_INLINE void overlapInHeight(const Floats& bottom, const Floats& top, const Wall& wall,
                                            Ints& overlaps) {
  constexpr float kGap = 0.05f;  // [m]
  overlaps = (bottom - wall.top <= kGap) & (wall.bottom - top <= kGap);
}

/** \brief How many edges two walls have in common: float, or Floats for eight pairs of walls.
 * \param lower, upper differences in height of these edges, NaN where one of the two is not seen [m] */
template <typename Number>
FACETLOC_ALWAYS_INLINE void countEdges(const Number& lower, const Number& upper, Number& edges) {
  constexpr float kError = 0.06f;  // [m]
  const Number none{}, one = none + 1;
  const auto same_lower = (lower < kError) & (lower > -kError),
             same_upper = (upper < kError) & (upper > -kError);
  edges = (same_lower ? one : none) + (same_upper ? one : none);
}

}  // namespace facetloc::internal
