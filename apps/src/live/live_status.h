// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"
#include "live/live_result.h"

#include <chrono>
#include <optional>
#include <string>

namespace facetloc {

/** \brief "tracking" and why, or how far a map has come, in words for one line. */
std::string stateText(const LiveResult& result);
/** \brief Stage times, age and drops of a frame, and the frame rate [Hz]. */
std::string timesText(const LiveResult& result, double rate);

/** \brief Where the camera is and how exactly, or the segments that it sees, on one line. \param map may be
 * null \param heading_deg in the plan, if it is known \param matched segments of the view that the local
 * model has */
std::string poseText(const LiveResult& result, const Map* map, std::optional<double> heading_deg,
                     std::size_t matched);

/** \brief A segment of the view: its number, size, distance, and how exactly its plane is known. */
std::string segmentText(const View& view, std::size_t k);

/** \brief A local model of a map. */
std::string modelText(const Map& map, int i);

/** \brief Processed frames per second, over the last second or so. */
class FrameRate {
public:
  /** \brief So many frames have been processed by now. */
  void update(std::uint64_t frames);
  double value() const { return value_; }

private:
  using Clock = std::chrono::steady_clock;
  std::optional<Clock::time_point> since_;
  std::uint64_t frames_ = 0;
  double value_ = 0;
};

/** \brief One line on a terminal with the state of a live run; nothing without a terminal. */
class LiveStatus {
public:
  explicit LiveStatus(const Console& console)
      : console_(console), visible_(console.terminal && !console.quiet) {}
  ~LiveStatus() { clear(); }
  LiveStatus(const LiveStatus&) = delete;
  LiveStatus& operator=(const LiveStatus&) = delete;

  void show(const LiveResult& result, double rate);
  /** \brief Before anything else is written. */
  void clear();

private:
  const Console& console_;
  const bool visible_;
  bool shown_ = false;
};

}  // namespace facetloc
