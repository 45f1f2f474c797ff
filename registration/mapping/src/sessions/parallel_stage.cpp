// SPDX-License-Identifier: BSD-3-Clause
#include "sessions/parallel_stage.h"

#include "threads/in_parallel.h"

#include <algorithm>
#include <thread>

namespace facetloc::internal {

ParallelStage::ParallelStage(MapProgress::Stage stage, std::size_t total, int threads,
                             const MapProgressCallback& progress)
    : threads_(threads > 0 ? threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()))),
      callback_(progress),
      progress_{stage, 0, total} {}

void ParallelStage::run(std::size_t first, std::size_t last, const std::function<void(std::size_t)>& job) {
  std::atomic<bool> ended{false};
  forEachInParallel(static_cast<int>(last - first), threads_, [&](int i) {
    if (ended) return;
    try {
      job(first + static_cast<std::size_t>(i));
      step();
    } catch (...) {
      ended = true;
      throw;
    }
  });
}

void ParallelStage::step() {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++progress_.done;
  if (callback_) callback_(progress_);
}

}  // namespace facetloc::internal
