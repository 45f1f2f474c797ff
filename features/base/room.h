// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

namespace facetloc::internal {

/** \brief Room for n elements; if there was none, for half as many again, since the next images of a camera
 * need a few more. */
template <class T>
void makeRoom(std::vector<T>& v, std::size_t n) {
  if (v.capacity() < n) v.reserve(n + n / 2);
}

}  // namespace facetloc::internal
