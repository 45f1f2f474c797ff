// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "live/live_source.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/depth_values.h>
#include <facetloc/io/error.h>

#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace facetloc {

/** \brief Plays a recording of any layout image by image, by their times or each when it is asked for.
 *
 * Images that cannot be read, or are of another size than the first one, are skipped. */
class FilePlayer {
public:
  /** \brief Throws IoError unless the recording can be read. */
  explicit FilePlayer(const LiveSourceOptions& options)
      : options_(options), sequence_(DepthSequence::open(options.device, hintsOf(options))) {}
  ~FilePlayer() { stop(); }

  /** \brief Plays to the sink, on a thread of its own; once. */
  void start(const FrameSink& sink) {
    thread_ = std::thread([this, sink] { run(sink); });
  }

  /** \brief When it returns, the sink is not called any more. */
  void stop() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stopped_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
  }

  /** \brief With LiveSourceOptions::every_frame: also gives the next image to the sink. */
  void next() {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++asked_;
    changed_.notify_all();
  }

  const std::optional<CameraFile>& camera() const { return sequence_.camera(); }
  /** \brief Findings of reading its files. */
  Findings findings() const { return readingFindings(sequence_); }
  /** \brief Is there no image left? Never with repeat. */
  bool atEnd() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return ended_;
  }

  /** \brief Why the last image that was skipped could not be read; empty if all could. */
  std::string lastError() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return error_;
  }

private:
  using Clock = std::chrono::steady_clock;
  static constexpr double kUsualRate = 30;  // [Hz] of images without times
  static constexpr double kLongestGap = 2;  // [s] between images; a longer one in the stamps is cut short
  static constexpr double kLate = 0.1;      // [s] after which being late sets a new start

  static RecordingHints hintsOf(const LiveSourceOptions& options) {
    RecordingHints hints;
    hints.camera = options.camera;
    hints.topic = options.topic;
    return hints;
  }

  void run(const FrameSink& sink) {
    do {
      playOnce(sink);
      const std::lock_guard<std::mutex> lock(mutex_);
      due_.reset();
      if (stopped_) return;
    } while (options_.repeat && width_ > 0);
    const std::lock_guard<std::mutex> lock(mutex_);
    ended_ = true;
  }

  void playOnce(const FrameSink& sink) {
    for (std::size_t i = 0; i < sequence_.frames().size(); ++i) {
      std::optional<DepthImage> loaded = load(i);  // ahead of its time, to be punctual
      if (!loaded) continue;
      const auto image = std::make_shared<const DepthImage>(std::move(*loaded));
      if (!wait(stampOf(i))) return;
      sink({stampOf(i), [image] { return *image; }});
    }
  }

  std::optional<DepthImage> load(std::size_t index) try {
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
  bool wait(double stamp) {
    std::unique_lock<std::mutex> lock(mutex_);
    if (options_.every_frame) changed_.wait(lock, [this] { return stopped_ || asked_ > 0; });
    auto due = Clock::now();
    if (due_ && options_.speed > 0) {
      // Measured from when the last one was due, so that small delays do not add up.
      const double gap = std::clamp(stamp - stamp_, 0.0, kLongestGap) / options_.speed;
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

  double stampOf(std::size_t index) const {
    return sequence_.stamped() ? sequence_.frames()[index].stamp : static_cast<double>(index) / kUsualRate;
  }

  const LiveSourceOptions options_;
  const DepthSequence sequence_;
  int width_ = 0, height_ = 0;  // size of the first image [px]
  mutable std::mutex mutex_;    // guards the members below
  std::condition_variable changed_;
  bool stopped_ = false, ended_ = false;
  std::uint64_t asked_ = 1;  // images that were asked for and not delivered
  std::optional<Clock::time_point> due_;
  double stamp_ = 0;  // stamp of the image that was due then [s]
  std::string error_;
  std::thread thread_;
};

}  // namespace facetloc
