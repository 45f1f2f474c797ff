// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "threads/in_parallel.h"

#include <facetloc/mapping/map_image.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <thread>

namespace facetloc::internal {

/** \brief A stage of making a map: work on many items by several threads, with progress. */
class ParallelStage {
public:
  /** \param total number of all items \param threads 0 = all cores */
  ParallelStage(MapProgress::Stage stage, std::size_t total, int threads, const MapProgressCallback& progress)
      : threads_(threads > 0 ? threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()))),
        callback_(progress),
        progress_{stage, 0, total} {}

  int threads() const { return threads_; }

  /** \brief Calls job for the items first, ..., last - 1, each once. Throws the exceptions of jobs and of the
   * callback; the items that were not begun by then are left out. */
  void run(std::size_t first, std::size_t last, const std::function<void(std::size_t)>& job) {
    std::atomic<bool> ended{false};
    forEachInParallel(static_cast<int>(last - first), threads_, [&](int i) {
      if (ended) return;
      try {
        job(first + static_cast<std::size_t>(i));
        const std::lock_guard<std::mutex> lock(mutex_);
        ++progress_.done;
        if (callback_) callback_(progress_);
      } catch (...) {
        ended = true;
        throw;
      }
    });
  }
  void run(const std::function<void(std::size_t)>& job) { run(0, progress_.total, job); }

private:
  int threads_;
  const MapProgressCallback& callback_;
  std::mutex mutex_;
  MapProgress progress_;
};

}  // namespace facetloc::internal
