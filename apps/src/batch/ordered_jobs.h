// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/stop_signal.h"

#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace facetloc {

/** \brief Jobs that several threads do, each taking the next one that is not taken yet; they are waited for
 * in their order. With one thread, the caller does each job when it is waited for. */
class OrderedJobs {
public:
  using Job = std::function<void(std::size_t index, int worker)>;
  /** \brief Begins with the first of n jobs. \param ahead how far jobs may run ahead of the one that is
   * waited for; their results are kept until then \param stop no job begins once it is raised */
  OrderedJobs(int threads, std::size_t n, std::size_t ahead, Job job, const StopSignal& stop)
      : n_(n), ahead_(std::max<std::size_t>(ahead, 1)), job_(std::move(job)), stop_(stop), ended_(n) {
    if (threads < 2) return;
    const std::lock_guard lock(mutex_);
    try {
      for (int worker = 0; worker < threads; ++worker) {
        threads_.emplace_back(&OrderedJobs::work, this, worker);
        ++working_;
      }
    } catch (const std::system_error&) {
      // There may be no more threads: those that there are do all the work.
    }
  }

  /** \brief Waits for the jobs that have begun. */
  ~OrderedJobs() {
    {
      const std::lock_guard lock(mutex_);
      cancelled_ = true;
    }
    changed_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

  /** \brief Waits for the end of the next job. \return false if it does not begin any more. Throws the
   * exception of any job. */
  bool next() {
    if (threads_.empty()) {
      if (isOver()) return false;
      job_(begun_++, 0);
      return true;
    }
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return why_ || ended_[waited_for_] || working_ == 0; });
    if (why_) std::rethrow_exception(why_);
    if (!ended_[waited_for_]) return false;
    ++waited_for_;
    changed_.notify_all();
    return true;
  }

private:
  void work(int worker) {
    std::unique_lock lock(mutex_);
    while (true) {
      changed_.wait(lock, [&] { return isOver() || begun_ < waited_for_ + ahead_; });
      if (isOver()) break;
      const std::size_t index = begun_++;
      lock.unlock();
      std::exception_ptr thrown;
      try {
        job_(index, worker);
      } catch (...) {
        thrown = std::current_exception();
      }
      lock.lock();
      if (thrown) why_ = thrown;
      ended_[index] = true;
      changed_.notify_all();
    }
    --working_;
    changed_.notify_all();
  }

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
