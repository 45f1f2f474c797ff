// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "frame_source.h"

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
  float speed() const;
  bool repeats() const;
  std::string error() const;
  void setSpeed(float speed);
  void setRepeat(bool repeat);
  void setError(const std::string& error);
  /** \brief n >= 0: n more images and no other, as fast as possible; < 0: real time. */
  void trigger(int frames);
  void seek(std::size_t index);

  /** \brief Starts playback: next() waits from now on. A sequence that had ended begins again. */
  void start();
  /** \brief Ends a wait. */
  void stop();
  /** \brief The image to prepare; nothing when stopped. At the end it calls on_end once, and waits for a
   * change of that. */
  template <typename OnEnd>
  std::optional<std::size_t> next(const OnEnd& on_end);
  /** \brief Waits until an image is due. False when it is not to be delivered: stopped, or another was
   * sought. */
  bool wait(std::size_t index);
  /** \brief Goes on after an image that cannot be served. */
  void skip(std::size_t index);

private:
  using Clock = std::chrono::steady_clock;

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

template <typename OnEnd>
std::optional<std::size_t> Playback::next(const OnEnd& on_end) {
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

}  // namespace facetloc
