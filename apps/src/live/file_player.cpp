// SPDX-License-Identifier: BSD-3-Clause
#include "live/file_player.h"

#include <facetloc/io/error.h>

#include <algorithm>
#include <memory>

namespace facetloc {
namespace {

constexpr double kUsualRate = 30;  // [Hz] of images without times
constexpr double kLongestGap = 2;  // [s] between images; a longer one in the stamps is cut short
constexpr double kLate = 0.1;      // [s] after which being late sets a new start

RecordingHints hintsOf(const LiveSourceOptions& options) {
  RecordingHints hints;
  hints.camera = options.camera;
  hints.topic = options.topic;
  return hints;
}

}  // namespace

FilePlayer::FilePlayer(const LiveSourceOptions& options)
    : options_(options), sequence_(DepthSequence::open(options.device, hintsOf(options))) {}

void FilePlayer::start(const FrameSink& sink) {
  thread_ = std::thread([this, sink] { run(sink); });
}

void FilePlayer::stop() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopped_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void FilePlayer::next() {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++asked_;
  changed_.notify_all();
}

bool FilePlayer::atEnd() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return ended_;
}

std::string FilePlayer::lastError() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return error_;
}

void FilePlayer::run(const FrameSink& sink) {
  do {
    playOnce(sink);
    const std::lock_guard<std::mutex> lock(mutex_);
    due_.reset();
    if (stopped_) return;
  } while (options_.repeat && width_ > 0);
  const std::lock_guard<std::mutex> lock(mutex_);
  ended_ = true;
}

void FilePlayer::playOnce(const FrameSink& sink) {
  for (std::size_t i = 0; i < sequence_.frames().size(); ++i) {
    std::optional<DepthImage> loaded = load(i);  // ahead of its time, to be punctual
    if (!loaded) continue;
    const auto image = std::make_shared<const DepthImage>(std::move(*loaded));
    if (!wait(stampOf(i))) return;
    sink({stampOf(i), [image] { return *image; }});
  }
}

std::optional<DepthImage> FilePlayer::load(std::size_t index) try {
  DepthImage image = sequence_.load(index);
  if (width_ == 0) width_ = image.camera.width, height_ = image.camera.height;
  if (image.camera.width == width_ && image.camera.height == height_) return image;
  throw IoError(sequence_.frames()[index].path.string(), "is of another size than the first image");
} catch (const std::exception& e) {
  const std::lock_guard<std::mutex> lock(mutex_);
  error_ = e.what();
  return {};
}

/** Until an image is due; false when the player is stopped. */
bool FilePlayer::wait(double stamp) {
  std::unique_lock<std::mutex> lock(mutex_);
  if (options_.every_frame) changed_.wait(lock, [this] { return stopped_ || asked_ > 0; });
  auto due = Clock::now();
  if (due_ && options_.speed > 0) {
    // Measured from when the last one was due, so that small delays do not add up.
    const double gap = std::clamp((stamp - stamp_) / options_.speed, 0.0, kLongestGap);
    const auto planned =
        *due_ + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(gap));
    if (due - planned < std::chrono::duration<double>(kLate)) due = planned;
    changed_.wait_until(lock, due, [this] { return stopped_; });
  }
  due_ = due;
  stamp_ = stamp;
  if (options_.every_frame && !stopped_) --asked_;
  return !stopped_;
}

double FilePlayer::stampOf(std::size_t index) const {
  return sequence_.stamped() ? sequence_.frames()[index].stamp : static_cast<double>(index) / kUsualRate;
}

}  // namespace facetloc
