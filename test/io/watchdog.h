// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <thread>

namespace facetloc::test {

constexpr auto kPatience = std::chrono::seconds(300);  // on a busy machine; longer means that it hangs

/** \brief Ends the process if it is not gone in time: a test that hangs is a test that failed. */
class Watchdog {
public:
  Watchdog()
      : thread_([this] {
          std::unique_lock lock(mutex_);
          if (done_.wait_for(lock, kPatience, [this] { return is_done_; })) return;
          std::fprintf(stderr, "the test hangs\n");
          std::_Exit(EXIT_FAILURE);
        }) {}
  ~Watchdog() {
    {
      const std::lock_guard lock(mutex_);
      is_done_ = true;
    }
    done_.notify_all();
    thread_.join();
  }

private:
  std::mutex mutex_;
  std::condition_variable done_;
  bool is_done_ = false;
  std::thread thread_;
};

/** \brief Waits until a condition holds. \return false if it does not hold after kPatience */
template <typename Condition>
bool waitUntil(const Condition& condition) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace facetloc::test
