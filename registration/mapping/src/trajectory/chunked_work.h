// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "threads/in_parallel.h"

#include <algorithm>
#include <functional>

namespace facetloc::internal {

/** \brief Threads of a computation, and the function that receives its progress. */
struct ChunkedWork {
  int threads = 1;                         ///< 0 = all cores
  std::function<void(double)> progress{};  ///< receives the share of the work that is done; may be empty

  /** \brief A section of this work, between two shares of it. */
  ChunkedWork section(double begin, double end) const {
    if (!progress) return *this;
    return {threads, [report = progress, begin, end](double done) { report(begin + done * (end - begin)); }};
  }

  /** \brief Calls a function with 0 .. n - 1 in parallel, and reports progress in between. */
  void forEach(int n, const std::function<void(int)>& function) const {
    constexpr int kChunk = 64;
    for (int first = 0; first < n; first += kChunk) {
      if (progress) progress(double(first) / n);
      forEachInParallel(std::min(kChunk, n - first), threads, [&](int i) { function(first + i); });
    }
  }
};

}  // namespace facetloc::internal
