// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/mapping/map_image.h>

#include <atomic>
#include <mutex>

namespace facetloc::internal {

/** \brief A stage of making a map: work on many items by several threads, with progress. */
class ParallelStage {
public:
  /** \param total number of all items \param threads 0 = all cores */
  ParallelStage(MapProgress::Stage stage, std::size_t total, int threads,
                const MapProgressCallback& progress);

  int threads() const { return threads_; }
  /** \brief Calls job for the items first, ..., last - 1, each once. Throws the exceptions of jobs and of the
   * callback; the items that were not begun by then are left out. */
  void run(std::size_t first, std::size_t last, const std::function<void(std::size_t)>& job);
  void run(const std::function<void(std::size_t)>& job) { run(0, progress_.total, job); }

private:
  void step();

  int threads_;
  const MapProgressCallback& callback_;
  std::mutex mutex_;
  MapProgress progress_;
};

}  // namespace facetloc::internal
