// SPDX-License-Identifier: BSD-3-Clause
#include "live/odometry_input.h"

#include <facetloc/io/error.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <iterator>
#include <poll.h>
#include <stdexcept>
#include <unistd.h>
#include <utility>

namespace facetloc {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kSilence(500);  // after which no line is waited for
constexpr milliseconds kPatience(50);  // with a line that is as late as a frame's own way through a driver
constexpr int kWakeUp = 100;           // to look whether it is to end [ms]
constexpr double kLongestStep = 0.5;   // longest gap between two lines that is bridged [s]
constexpr double kKept = 60;           // [s]
constexpr std::size_t kMostPoses = 100000;
constexpr std::size_t kMostFaults = 100;  // capacity of the queue
constexpr std::size_t kLongestLine = 1 << 16;

}  // namespace

OdometryInput::OdometryInput(const std::string& file, const std::optional<CameraMounting>& mounting)
    : name_(file.empty() || file == "-" ? "standard input" : file), mounting_(mounting) {
  if (file.empty()) return;
  closes_ = file != "-";
  file_ = closes_ ? ::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC) : STDIN_FILENO;
  if (file_ < 0) throw IoError(file, std::string("cannot be opened: ") + std::strerror(errno));
  thread_ = std::thread([this] { read(); });
}

OdometryInput::~OdometryInput() {
  {
    const std::lock_guard lock(mutex_);
    stops_ = true;
  }
  arrived_.notify_all();
  if (thread_.joinable()) thread_.join();
  if (closes_) ::close(file_);
}

double OdometryInput::sinceStart(Clock::time_point time) const {
  return std::chrono::duration<double>(time - start_).count();
}

/** Until the end of the input or of this. */
void OdometryInput::read() {
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

void OdometryInput::take(const std::string& text) {
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

void OdometryInput::addFault(std::string fault) {
  if (faults_.size() < kMostFaults) faults_.push_back(std::move(fault));
}

std::optional<NumberedStart> OdometryInput::takeStart() {
  const std::lock_guard lock(mutex_);
  return std::exchange(start_line_, std::nullopt);
}

bool OdometryInput::takeRelocalize() {
  const std::lock_guard lock(mutex_);
  return std::exchange(relocalize_, false);
}

void OdometryInput::refuse(const NumberedStart& start, const std::string& cause) {
  const std::lock_guard lock(mutex_);
  addFault(fmt::format("{}: line {}: {}", name_, start.line, cause));
}

void OdometryInput::add(const OdometryLine& line, double now) {
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

std::optional<Eigen::Isometry3d> OdometryInput::at(double stamp, Clock::time_point arrival) {
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

std::string OdometryInput::fault() {
  const std::lock_guard lock(mutex_);
  if (faults_.empty()) return {};
  std::string first = std::move(faults_.front());
  faults_.pop_front();
  return first;
}

}  // namespace facetloc
