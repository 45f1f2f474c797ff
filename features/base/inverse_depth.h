// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

namespace facetloc::internal {

/** \brief Inverse depths of n depths, times scale; 0 = not measured. */
void invertDepth(const float* depth, std::size_t n, float scale, float* out);

}  // namespace facetloc::internal
