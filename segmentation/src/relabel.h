// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace facetloc::internal {

/** \brief Label k becomes new_label[k]. Four pixels at a time, which mostly are like the four before. */
inline void relabel(std::vector<std::uint16_t>& labels, const std::vector<std::uint16_t>& new_label) {
  constexpr std::ptrdiff_t kTogether = 4;
  std::uint16_t* k = labels.data();
  std::uint16_t* const end = k + labels.size();
  std::uint64_t four, known = 0, replacement = 0x0001000100010001u * new_label[0];
  for (; end - k >= kTogether; k += kTogether) {
    std::memcpy(&four, k, sizeof four);
    if (four != known) {
      known = four;
      std::uint16_t out[kTogether];
      for (std::ptrdiff_t i = 0; i < kTogether; ++i) out[i] = new_label[k[i]];
      std::memcpy(&replacement, out, sizeof out);
    }
    std::memcpy(k, &replacement, sizeof replacement);
  }
  for (; k < end; ++k) *k = new_label[*k];
}

}  // namespace facetloc::internal
