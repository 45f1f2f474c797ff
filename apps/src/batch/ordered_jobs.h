// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/stop_signal.h"

#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace facetloc {

/** \brief Jobs that several threads do, each taking the next one that is not taken yet; they are waited for
 * in their order. With one thread, the caller does each job when it is waited for. */
class OrderedJobs {
public:
  using Job = std::function<void(std::size_t index, int worker)>;
  /** \brief Begins with the first of n jobs. \param ahead how far jobs may run ahead of the one that is
   * waited for; their results are kept until then \param stop no job begins once it is raised */
  OrderedJobs(int threads, std::size_t n, std::size_t ahead, Job job, const StopSignal& stop);
  /** \brief Waits for the jobs that have begun. */
  ~OrderedJobs();
  OrderedJobs(const OrderedJobs&) = delete;
  OrderedJobs& operator=(const OrderedJobs&) = delete;

  /** \brief Waits for the end of the next job. \return false if it does not begin any more. Throws the
   * exception of any job. */
  bool next();

private:
  void work(int worker);
  bool isOver() const { return cancelled_ || why_ || stop_.raised() || begun_ == n_; }

  const std::size_t n_, ahead_;
  const Job job_;
  const StopSignal& stop_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t begun_ = 0;
  std::size_t waited_for_ = 0;
  std::vector<bool> ended_;
  std::exception_ptr why_;
  bool cancelled_ = false;
  std::size_t working_ = 0;  // threads
  std::vector<std::thread> threads_;
};

}  // namespace facetloc
