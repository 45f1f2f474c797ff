// SPDX-License-Identifier: BSD-3-Clause
#include "playback.h"

#include <algorithm>

namespace facetloc {
namespace {

constexpr std::chrono::seconds kLongestGap{2};  // between images; a longer one in the stamps is cut short

}  // namespace

float Playback::speed() const {
  const std::lock_guard lock(mutex_);
  return speed_;
}

bool Playback::repeats() const {
  const std::lock_guard lock(mutex_);
  return repeat_;
}

std::string Playback::error() const {
  const std::lock_guard lock(mutex_);
  return error_;
}

void Playback::setSpeed(float speed) {
  const std::lock_guard lock(mutex_);
  speed_ = speed;
  due_.reset();
  changed_.notify_all();
}

void Playback::setRepeat(bool repeat) {
  const std::lock_guard lock(mutex_);
  repeat_ = repeat;
  changed_.notify_all();
}

void Playback::setError(const std::string& error) {
  const std::lock_guard lock(mutex_);
  error_ = error;
}

void Playback::trigger(int frames) {
  const std::lock_guard lock(mutex_);
  credits_ = triggered_ ? credits_ + std::max(frames, 0) : std::max(frames, 0);
  triggered_ = frames >= 0;
  due_.reset();
  changed_.notify_all();
}

void Playback::seek(std::size_t index) {
  const std::lock_guard lock(mutex_);
  position_ = index;
  told_end_ = false;
  due_.reset();
  changed_.notify_all();
}

void Playback::start() {
  const std::lock_guard lock(mutex_);
  running_ = true;
  due_.reset();
  if (atEnd()) position_ = 0;
  told_end_ = false;
}

void Playback::stop() {
  const std::lock_guard lock(mutex_);
  running_ = false;
  changed_.notify_all();
}

void Playback::skip(std::size_t index) {
  const std::lock_guard lock(mutex_);
  if (position_ == index) ++position_;
}

bool Playback::wait(std::size_t index) {
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

}  // namespace facetloc
