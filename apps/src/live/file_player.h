// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "live/live_source.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/depth_values.h>

#include <condition_variable>
#include <cstddef>
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
  explicit FilePlayer(const LiveSourceOptions& options);
  ~FilePlayer() { stop(); }
  FilePlayer(const FilePlayer&) = delete;
  FilePlayer& operator=(const FilePlayer&) = delete;

  /** \brief Plays to the sink, on a thread of its own; once. */
  void start(const FrameSink& sink);
  /** \brief When it returns, the sink is not called any more. */
  void stop();
  /** \brief With LiveSourceOptions::every_frame: also gives the next image to the sink. */
  void next();

  const std::optional<CameraFile>& camera() const { return sequence_.camera(); }
  /** \brief Findings of reading its files. */
  Findings findings() const { return readingFindings(sequence_); }
  /** \brief Is there no image left? Never with repeat. */
  bool atEnd() const;
  /** \brief Why the last image that was skipped could not be read; empty if all could. */
  std::string lastError() const;

private:
  using Clock = std::chrono::steady_clock;

  void run(const FrameSink& sink);
  void playOnce(const FrameSink& sink);
  std::optional<DepthImage> load(std::size_t index);
  bool wait(double stamp);
  double stampOf(std::size_t index) const;

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
