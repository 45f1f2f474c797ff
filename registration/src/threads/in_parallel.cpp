// SPDX-License-Identifier: BSD-3-Clause
#include "threads/in_parallel.h"

#include <omp.h>

#include <algorithm>
#include <exception>
#include <vector>

namespace facetloc::internal {

void forEachInParallel(int n, int threads, const std::function<void(int)>& function) {
  std::vector<std::exception_ptr> failure(static_cast<std::size_t>(n));
  const int used = std::min(n, threads > 0 ? threads : omp_get_num_procs());
#pragma omp parallel for schedule(dynamic) num_threads(used) if (used > 1)
  for (int i = 0; i < n; ++i) try {
      function(i);
    } catch (...) {
      failure[i] = std::current_exception();
    }
  for (const std::exception_ptr& f : failure)
    if (f) std::rethrow_exception(f);
}

}  // namespace facetloc::internal
