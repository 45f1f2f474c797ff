// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace facetloc {

/** \brief A pose that an odometry tells, in a frame of its own, which may drift. */
struct OdometryLine {
  std::optional<double> stamp;  ///< [s]; none = now
  Eigen::Isometry3d T_o_c = Eigen::Isometry3d::Identity();
};

/** \brief Reads a line in the form of the stream (ROBOT.md): T_w_c, or T_w_b with the mounting, and stamp;
 * what else it has does not matter. Throws std::invalid_argument with the cause. */
OdometryLine parseOdometry(const std::string& line, const std::optional<CameraMounting>& mounting);

/** \brief Wheel odometry that comes line by line while frames do, on a thread of its own.
 *
 * A line without a stamp is of the time when it arrives, and stands beside frames by the time of their
 * arrival; one with a stamp by their stamps. The kind of the first line holds for all. */
class OdometryInput {
public:
  using Clock = std::chrono::steady_clock;

  /** \param file to read; "-" = standard input. Throws IoError if it cannot be opened. */
  OdometryInput(const std::string& file, const std::optional<CameraMounting>& mounting);
  ~OdometryInput();
  OdometryInput(const OdometryInput&) = delete;
  OdometryInput& operator=(const OdometryInput&) = delete;

  /** \brief T_o_c at the time of a frame, between the lines before and after it; waits a while for the one
   * after. Nothing if the lines do not reach there, or are too far apart. */
  std::optional<Eigen::Isometry3d> at(double stamp, Clock::time_point arrival);
  /** \brief What was wrong with the first line that could not be read, once; empty if there is nothing new.
   */
  std::string fault();

private:
  struct Pose {
    double time = 0;  // [s]
    Eigen::Isometry3d T_o_c;
  };
  void read();
  void take(const std::string& line);
  void add(const OdometryLine& line, double now);
  double sinceStart(Clock::time_point time) const;

  const std::string name_;
  const std::optional<CameraMounting> mounting_;
  const Clock::time_point start_ = Clock::now();
  int file_ = -1;
  bool closes_ = false;  // it is ours

  std::mutex mutex_;  // of all below
  std::condition_variable arrived_;
  std::deque<Pose> poses_;    // in the order of their times
  Clock::time_point latest_;  // arrival of the last line
  std::optional<bool> is_stamped_;
  std::uint64_t lines_ = 0;
  std::string fault_;
  bool has_fault_ = false, ended_ = false, stops_ = false;
  std::thread thread_;  // the last member: it uses all others
};

}  // namespace facetloc
