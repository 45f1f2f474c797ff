// SPDX-License-Identifier: BSD-3-Clause
#include "devices/openni_handle.h"

#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>

namespace facetloc {
namespace {

/** Has as many threads as there were ever tasks at once. */
class Pool {
public:
  void run(std::function<void()> task) {
    const std::lock_guard lock(mutex_);
    if (tasks_.size() >= idle_) {
      std::thread([this] { work(); }).detach();  // before the task is anywhere: this may throw
      ++idle_;
    }
    tasks_.push_back(std::move(task));
    given_.notify_one();
  }

private:
  [[noreturn]] void work() {
    std::unique_lock lock(mutex_);
    for (;;) {
      given_.wait(lock, [this] { return !tasks_.empty(); });
      std::function<void()> task = std::move(tasks_.front());
      tasks_.pop_front();
      --idle_;
      lock.unlock();
      task();
      task = nullptr;
      lock.lock();
      ++idle_;
    }
  }

  std::mutex mutex_;
  std::condition_variable given_;
  std::deque<std::function<void()>> tasks_;  // that no thread has taken yet
  std::size_t idle_ = 0;                     // threads; at least one for each of those tasks
};

}  // namespace

void runOnPersistentThread(std::function<void()> task) {
  static Pool& pool = *new Pool;  // never destroyed: its threads outlive main()
  pool.run(std::move(task));
}

}  // namespace facetloc
