// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "inputs/robot_line.h"

#include <facetloc/features/camera_model.h>
#include <facetloc/io/error.h>
#include <facetloc/io/trajectory.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cstring>
#include <deque>
#include <fcntl.h>
#include <fmt/format.h>
#include <iterator>
#include <mutex>
#include <optional>
#include <poll.h>
#include <stdexcept>
#include <string>
#include <thread>
#include <unistd.h>
#include <utility>

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
  OdometryInput(const std::string& file, const std::optional<CameraMounting>& mounting)
      : name_(file.empty() || file == "-" ? "standard input" : file), mounting_(mounting) {
    if (file.empty()) return;
    closes_ = file != "-";
    file_ = closes_ ? ::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC) : STDIN_FILENO;
    if (file_ < 0) throw IoError(file, std::string("cannot be opened: ") + std::strerror(errno));
    thread_ = std::thread([this] { read(); });
  }

  ~OdometryInput() {
    {
      const std::lock_guard lock(mutex_);
      stops_ = true;
    }
    arrived_.notify_all();
    if (thread_.joinable()) thread_.join();
    if (closes_) ::close(file_);
  }

  /** \brief A line that came another way, with the frames. */
  void take(const std::string& text) {
    const double now = sinceStart(Clock::now());
    if (text.find_first_not_of(" \t\r") == std::string::npos) return;
    const std::lock_guard lock(mutex_);
    ++lines_;
    try {
      RobotLine line = parseRobotLine(text, mounting_);
      if (line.start) start_line_ = NumberedStart{std::move(*line.start), lines_};
      if (line.relocalize) {
        relocalize_ = true;
        start_line_.reset();  // said before
      }
      if (line.odometry) {
        add(*line.odometry, now);
        latest_ = Clock::now();
      }
      arrived_.notify_all();
    } catch (const RobotCommandError& e) {
      addFault(fmt::format("{}: line {}: {}", name_, lines_, e.what()));
    } catch (const std::exception& e) {
      if (!std::exchange(has_fault_, true))  // those of thousands of messages have the same cause
        addFault(fmt::format("{}: line {} is no odometry: {}", name_, lines_, e.what()));
    }
  }

  /** \brief T_o_c at the time of a frame, between the lines before and after it; waits a while for the one
   * after. Nothing if the lines do not reach there, or are too far apart. */
  std::optional<Eigen::Isometry3d> at(double stamp, Clock::time_point arrival) {
    std::unique_lock lock(mutex_);
    const auto time = [&] { return is_stamped_ && *is_stamped_ ? stamp : sinceStart(arrival); };
    const bool may_come = !ended_ && Clock::now() - latest_ < kSilence;
    arrived_.wait_for(lock, kPatience, [&] {
      return !may_come || stops_ || ended_ || (!poses_.empty() && poses_.back().stamp >= time());
    });
    const double when = time();
    const auto after = std::lower_bound(poses_.begin(), poses_.end(), when,
                                        [](const StampedPose& pose, double t) { return pose.stamp < t; });
    if (after == poses_.end()) return {};
    const StampedPose& before = after == poses_.begin() ? *after : *std::prev(after);
    if (after->stamp != when && after->stamp - before.stamp > kLongestStep) return {};
    return Trajectory({before, *after}).interpolated(when);
  }

  /** \brief The latest start that has come since the last call. */
  std::optional<NumberedStart> takeStart() {
    const std::lock_guard lock(mutex_);
    return std::exchange(start_line_, std::nullopt);
  }

  /** \brief Has a line asked to relocalize since the last call? */
  bool takeRelocalize() {
    const std::lock_guard lock(mutex_);
    return std::exchange(relocalize_, false);
  }

  /** \brief Reports the fault of a start that could be read. */
  void refuse(const NumberedStart& start, const std::string& cause) {
    const std::lock_guard lock(mutex_);
    addFault(fmt::format("{}: line {}: {}", name_, start.line, cause));
  }

  /** \brief The fault of the next line that could not be read, each once, of odometry only the first
   * one; empty if there is nothing new. */
  std::string fault() {
    const std::lock_guard lock(mutex_);
    if (faults_.empty()) return {};
    std::string first = std::move(faults_.front());
    faults_.pop_front();
    return first;
  }

private:
  using milliseconds = std::chrono::milliseconds;
  static constexpr milliseconds kSilence{500};  // after which no line is waited for
  static constexpr milliseconds kPatience{50};  // with a line as late as a frame's own way through a driver
  static constexpr int kWakeUp = 100;           // to look whether it is to end [ms]
  static constexpr double kLongestStep = 0.5;   // longest gap between two lines that is bridged [s]
  static constexpr double kKept = 60;           // [s]
  static constexpr std::size_t kMostPoses = 100000;
  static constexpr std::size_t kMostFaults = 100;  // capacity of the queue
  static constexpr std::size_t kLongestLine = 1 << 16;

  /** Until the end of the input or of this. */
  void read() {
    std::string text;
    const auto stops = [this] {
      const std::lock_guard lock(mutex_);
      return stops_;
    };
    for (bool more = true; more && !stops();) {
      pollfd waits{file_, POLLIN, 0};
      if (::poll(&waits, 1, kWakeUp) <= 0) continue;
      std::array<char, 4096> buffer{};
      const ssize_t n = ::read(file_, buffer.data(), buffer.size());
      if (n < 0 && (errno == EINTR || errno == EAGAIN)) continue;
      more = n > 0;
      if (more) text.append(buffer.data(), static_cast<std::size_t>(n));
      std::size_t begin = 0;
      for (std::size_t end; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1)
        take(text.substr(begin, end - begin));
      text.erase(0, begin);
      if (!more && !text.empty()) take(text);
      if (text.size() > kLongestLine) text.clear();  // the rest of the line is invalid as well
    }
    const std::lock_guard lock(mutex_);
    ended_ = true;
    arrived_.notify_all();
  }

  void addFault(std::string fault) {
    if (faults_.size() < kMostFaults) faults_.push_back(std::move(fault));
  }

  void add(const OdometryLine& line, double now) {
    const bool is_stamped = line.stamp.has_value();
    if (!is_stamped_) is_stamped_ = is_stamped;
    if (*is_stamped_ != is_stamped)
      throw std::invalid_argument(is_stamped ? "it has a stamp, unlike the first one"
                                             : "it has no stamp, unlike the first one");
    const double time = is_stamped ? *line.stamp : now;
    if (!poses_.empty() && !(time >= poses_.back().stamp)) poses_.clear();  // it begins anew
    poses_.push_back({time, line.T_o_c});
    while (poses_.size() > kMostPoses || poses_.front().stamp < time - kKept) poses_.pop_front();
  }

  double sinceStart(Clock::time_point time) const {
    return std::chrono::duration<double>(time - start_).count();
  }

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
