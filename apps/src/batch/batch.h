// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"
#include "cli/progress.h"

#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace facetloc {

/** \brief The user has pressed Ctrl-C; the message says how far the work has come. */
class Stopped : public std::runtime_error {
public:
  Stopped(std::size_t done, std::size_t total);
};

/** \brief Why an item failed; both are empty if it did not. */
struct ItemFailure {
  std::string reason;
  std::string message;  ///< names the item, too
};

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

/** \brief Work on many items with several threads, where one bad item stops nothing.
 *
 * Jobs store their results by index, so that the output is the same for any number of threads. Jobs that
 * throw are remembered with their cause, but for WriteError: if one item cannot be written, the next one
 * cannot either. Work that several processes share is a SharedBatch. */
class Batch {
public:
  /** \param threads 0 = all cores; \param total how many items there will be in all. */
  Batch(int threads, std::size_t total, const Console& console);

  /** \brief The number of workers: never more than items. */
  int workers() const { return workers_; }

  using Job = std::function<void(std::size_t index, int worker)>;
  using Name = std::function<std::string(std::size_t index)>;
  /** \brief Calls job for each item, once. \param name of an item, for messages. Throws WriteError of a job,
   * and Stopped at the first Ctrl-C or SIGTERM, once the items that were begun are done. */
  void run(const Name& name, const Job& job);

  /** \brief Name and cause of each item that failed so far, in the order of the items. */
  const std::vector<std::string>& failures() const { return failures_; }
  /** \brief Lists the failures on console.err. \return kFailed if there are any, else kOk. */
  int report() const;

  /** \brief As many workers as threads, 0 = all cores, but never more than items. */
  static int workersFor(int threads, std::size_t items);
  /** \brief Runs the job of an item; its failure, if it throws. Throws WriteError of its job. */
  static ItemFailure failureOf(const Name& name, std::size_t index, const std::function<void()>& job);
  static int report(const std::vector<std::string>& failures, std::size_t total, const Console& console);

private:
  int workers_;
  std::size_t total_;
  const Console& console_;
  Progress progress_;
  StopSignal stop_;
  std::vector<std::string> failures_;
};

}  // namespace facetloc
