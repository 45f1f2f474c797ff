// SPDX-License-Identifier: BSD-3-Clause
#include "batch/ordered_jobs.h"

#include <algorithm>
#include <system_error>
#include <utility>

namespace facetloc {

OrderedJobs::OrderedJobs(int threads, std::size_t n, std::size_t ahead, Job job, const StopSignal& stop)
    : n_(n), ahead_(std::max<std::size_t>(ahead, 1)), job_(std::move(job)), stop_(stop), ended_(n) {
  if (threads < 2) return;
  const std::lock_guard lock(mutex_);
  try {
    for (int worker = 0; worker < threads; ++worker) {
      threads_.emplace_back(&OrderedJobs::work, this, worker);
      ++working_;
    }
  } catch (const std::system_error&) {  // there may be no more threads: those that there are do all the work
  }
}

OrderedJobs::~OrderedJobs() {
  {
    const std::lock_guard lock(mutex_);
    cancelled_ = true;
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void OrderedJobs::work(int worker) {
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

bool OrderedJobs::next() {
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

}  // namespace facetloc
