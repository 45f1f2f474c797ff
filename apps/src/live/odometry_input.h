// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "inputs/robot_line.h"

#include <facetloc/features/camera_model.h>
#include <facetloc/io/trajectory.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace facetloc {

/** \brief A start by the number of its line. */
struct NumberedStart {
  StartLine start;
  std::uint64_t line = 0;
};

/** \brief Wheel odometry and commands that come line by line while frames do, on a thread of its own.
 *
 * A line without a stamp is of the time when it arrives, and stands beside frames by the time of their
 * arrival; one with a stamp by their stamps. The kind of the first line holds for all. */
class OdometryInput {
public:
  using Clock = std::chrono::steady_clock;

  /** \param file to read; "-" = standard input, empty = none: lines come by take() alone. Throws IoError if
   * it cannot be opened. */
  OdometryInput(const std::string& file, const std::optional<CameraMounting>& mounting);
  ~OdometryInput();
  OdometryInput(const OdometryInput&) = delete;
  OdometryInput& operator=(const OdometryInput&) = delete;

  /** \brief A line that came another way, with the frames. */
  void take(const std::string& line);
  /** \brief T_o_c at the time of a frame, between the lines before and after it; waits a while for the one
   * after. Nothing if the lines do not reach there, or are too far apart. */
  std::optional<Eigen::Isometry3d> at(double stamp, Clock::time_point arrival);
  /** \brief The latest start that has come since the last call. */
  std::optional<NumberedStart> takeStart();
  /** \brief Has a line asked to relocalize since the last call? */
  bool takeRelocalize();
  /** \brief Reports the fault of a start that could be read. */
  void refuse(const NumberedStart& start, const std::string& cause);
  /** \brief The fault of the next line that could not be read, each once, of odometry only the first
   * one; empty if there is nothing new. */
  std::string fault();

private:
  void read();
  void addFault(std::string fault);
  void add(const OdometryLine& line, double now);
  double sinceStart(Clock::time_point time) const;

  const std::string name_;
  const std::optional<CameraMounting> mounting_;
  const Clock::time_point start_ = Clock::now();
  int file_ = -1;
  bool closes_ = false;  // it is ours

  std::mutex mutex_;  // guards all members below
  std::condition_variable arrived_;
  std::deque<StampedPose> poses_;  // T_o_c, sorted by time
  Clock::time_point latest_;       // arrival of the last line
  std::optional<bool> is_stamped_;
  std::uint64_t lines_ = 0;
  std::optional<NumberedStart> start_line_;
  bool relocalize_ = false;
  std::deque<std::string> faults_;
  bool has_fault_ = false, ended_ = false, stops_ = false;
  std::thread thread_;  // the last member: it uses all others
};

}  // namespace facetloc
