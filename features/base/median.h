// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <iterator>
#include <vector>

namespace facetloc::internal {

/** \brief Median of at least one value: of an even number of values the upper of the two in the middle.
 * Reorders the range. */
template <class Iterator>
typename std::iterator_traits<Iterator>::value_type median(Iterator begin, Iterator end) {
  const Iterator middle = begin + (end - begin) / 2;
  std::nth_element(begin, middle, end);
  return *middle;
}

template <class Number>
Number median(std::vector<Number> values) {
  return median(values.begin(), values.end());
}

}  // namespace facetloc::internal
