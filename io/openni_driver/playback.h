// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "frame_source.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

namespace facetloc {

/** \brief Order and times of the images: set by programs through the device, used by the stream's thread. */
class Playback {
public:
  explicit Playback(std::unique_ptr<FrameSource> source) : source_(std::move(source)) {}

  const FrameSource& source() const { return *source_; }
  float speed() const { return locked(speed_); }
  bool repeats() const { return locked(repeat_); }
  std::string error() const { return locked(error_); }
  void setSpeed(float speed) {
    change([&] { speed_ = speed, due_.reset(); });
  }
  void setRepeat(bool repeat) {
    change([&] { repeat_ = repeat; });
  }
  void setError(const std::string& error) {
    change([&] { error_ = error; });
  }
  /** \brief n >= 0: n more images and no other, as fast as possible; < 0: real time. */
  void trigger(int frames) {
    change([&] {
      credits_ = triggered_ ? credits_ + std::max(frames, 0) : std::max(frames, 0);
      triggered_ = frames >= 0;
      due_.reset();
    });
  }
  void seek(std::size_t index) {
    change([&] { position_ = index, told_end_ = false, due_.reset(); });
  }

  /** \brief Starts playback: next() waits from now on. A sequence that had ended begins again. */
  void start() {
    const std::lock_guard lock(mutex_);
    running_ = true;
    due_.reset();
    if (atEnd()) position_ = 0;
    told_end_ = false;
  }

  /** \brief Ends a wait. */
  void stop() {
    change([this] { running_ = false; });
  }

  /** \brief The image to prepare; nothing when stopped. At the end it calls on_end once, and waits for a
   * change of that. */
  template <typename OnEnd>
  std::optional<std::size_t> next(const OnEnd& on_end) {
    std::unique_lock lock(mutex_);
    while (running_) {
      if (!atEnd()) return position_;
      if (repeat_) {
        position_ = 0;
        due_.reset();
        continue;
      }
      if (!told_end_) {
        told_end_ = true;
        lock.unlock();  // the callback may stop us
        on_end();
        lock.lock();
        continue;
      }
      changed_.wait(lock);
    }
    return {};
  }

  /** \brief Waits until an image is due. False when it is not to be delivered: stopped, or another was
   * sought. */
  bool wait(std::size_t index) {
    std::unique_lock lock(mutex_);
    const std::uint64_t stamp = source_->stamp(index);
    while (running_ && position_ == index) {
      if (!mayDeliver()) {
        changed_.wait(lock);
        continue;
      }
      const auto now = Clock::now();
      // Measured from when the last one was due, so that small delays do not add up; a late one sets a new
      // start.
      auto due = now;
      if (due_ && !triggered_ && speed_ > 0) {
        const std::chrono::duration<double, std::micro> gap(
            (static_cast<double>(stamp) - static_cast<double>(stamp_)) / static_cast<double>(speed_));
        due = *due_ + std::clamp<Clock::duration>(std::chrono::duration_cast<Clock::duration>(gap),
                                                  Clock::duration::zero(), kLongestGap);
        if (due > now) {
          changed_.wait_until(lock, due);
          continue;
        }
        const auto period = std::chrono::microseconds(std::chrono::seconds(1)) / source_->rate();
        if (now - due > period) due = now;
      }
      due_ = due;
      stamp_ = stamp;
      if (triggered_) --credits_;
      ++position_;
      return true;
    }
    return false;
  }

  /** \brief Goes on after an image that cannot be served. */
  void skip(std::size_t index) {
    const std::lock_guard lock(mutex_);
    if (position_ == index) ++position_;
  }

private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::seconds kLongestGap{2};  // between images; a longer one is cut short

  template <typename Value>
  Value locked(const Value& value) const {
    const std::lock_guard lock(mutex_);
    return value;
  }
  template <typename Apply>
  void change(const Apply& apply) {
    const std::lock_guard lock(mutex_);
    apply();
    changed_.notify_all();
  }
  bool atEnd() const { return position_ >= source_->size(); }
  bool mayDeliver() const { return !triggered_ || credits_ > 0; }

  std::unique_ptr<FrameSource> source_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool running_ = false;
  bool repeat_ = true;  // as OpenNI2's own player
  bool told_end_ = false;
  bool triggered_ = false;
  int credits_ = 0;
  float speed_ = 1;
  std::size_t position_ = 0;
  std::optional<Clock::time_point> due_;  // time of the last image delivered
  std::uint64_t stamp_ = 0;               // stamp of that image [us]
  std::string error_;
};

}  // namespace facetloc
