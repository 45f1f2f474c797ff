// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>

namespace facetloc {

inline double millisecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace facetloc
