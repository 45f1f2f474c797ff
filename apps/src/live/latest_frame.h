// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>

namespace facetloc {

/** \brief A mailbox of one frame: who puts never waits, who takes gets the newest one; a frame that is still
 * there when the next one comes is dropped and counted. Thread-safe, any number of threads on either side.
 *
 * Frames are destroyed outside of the lock: theirs may be a buffer of a driver. */
template <class Frame>
class LatestFrame {
public:
  using Clock = std::chrono::steady_clock;

  struct Arrived {
    Frame frame;
    Clock::time_point arrival;
  };
  struct Counts {
    std::uint64_t received = 0;  ///< all that came before it was closed
    std::uint64_t dropped = 0;   ///< received frames that no one took
    bool waiting = false;        ///< there is one that can still be taken
  };

  /** \brief Leaves a frame, which arrives now. A closed mailbox ignores it. */
  void put(Frame frame) {
    std::optional<Arrived> arrived{{std::move(frame), Clock::now()}};
    const std::lock_guard<std::mutex> lock(mutex_);
    if (closed_) return;
    ++counts_.received;
    counts_.dropped += frame_.has_value();
    last_arrival_ = arrived->arrival;
    frame_.swap(arrived);  // the replaced frame is destroyed after the lock is released
    filled_.notify_one();
  }

  /** \brief Leaves a frame as soon as the one before has been taken: nothing is dropped. Once the
   * mailbox is closed, returns at once and drops the frame. */
  void putInTurn(Frame frame) {
    {
      std::unique_lock<std::mutex> lock(mutex_);
      emptied_.wait(lock, [this] { return !frame_ || closed_; });
    }
    put(std::move(frame));
  }

  /** \brief The newest frame, as soon as there is one; nothing after the timeout, or if the mailbox is empty
   * and closed. */
  std::optional<Arrived> take(Clock::duration timeout) {
    std::unique_lock<std::mutex> lock(mutex_);
    filled_.wait_for(lock, timeout, [this] { return frame_ || closed_; });
    std::optional<Arrived> taken = std::exchange(frame_, std::nullopt);
    lock.unlock();
    emptied_.notify_all();
    return taken;
  }

  /** \brief No frame gets in any more; the one that is there can still be taken. Wakes who waits. */
  void close() {
    const std::lock_guard<std::mutex> lock(mutex_);
    closed_ = true;
    filled_.notify_all();
    emptied_.notify_all();
  }
  bool closed() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return closed_;
  }
  /** \brief Discards the waiting frame, which counts as dropped. */
  void clear() {
    std::optional<Arrived> gone;  // destroyed after the lock is released
    const std::lock_guard<std::mutex> lock(mutex_);
    counts_.dropped += frame_.has_value();
    gone.swap(frame_);
    emptied_.notify_all();
  }

  Counts counts() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return {counts_.received, counts_.dropped, frame_.has_value()};
  }
  /** \brief When the last frame came, if one ever did. */
  std::optional<Clock::time_point> lastArrival() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return last_arrival_;
  }

private:
  mutable std::mutex mutex_;
  std::condition_variable filled_, emptied_;
  std::optional<Arrived> frame_;
  std::optional<Clock::time_point> last_arrival_;
  Counts counts_;  // but for waiting
  bool closed_ = false;
};

}  // namespace facetloc
