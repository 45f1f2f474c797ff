// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstring>

namespace facetloc::internal {

/** \brief The bits of a float. Floats that are not negative order like their bits, so that one comparison of
 * integers orders by such a float and, behind it, an index. */
inline std::uint64_t bitsOf(float x) {
  std::uint32_t bits;
  std::memcpy(&bits, &x, sizeof bits);
  return bits;
}

}  // namespace facetloc::internal
