// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

namespace facetloc::internal {

/** \brief Calls a function with 0 .. n - 1 in parallel. The exception thrown does not depend on the number of
 * threads, 0 = all cores. */
void forEachInParallel(int n, int threads, const std::function<void(int)>& function);

}  // namespace facetloc::internal
