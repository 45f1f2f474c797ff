// SPDX-License-Identifier: BSD-3-Clause
#include "live/odometry_input.h"

#include <facetloc/io/error.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <iterator>
#include <json/json.h>
#include <memory>
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
constexpr double kLongestStep = 0.5;   // between two lines, in which nobody knows how the robot moved [s]
constexpr double kKept = 60;           // [s]
constexpr std::size_t kMostPoses = 100000;
constexpr std::size_t kLongestLine = 1 << 16;

template <int N>
Eigen::Matrix<double, N, 1> numbersOf(const Json::Value& pose, const char* key) {
  const Json::Value& list = pose[key];
  if (!list.isArray() || list.size() != static_cast<Json::ArrayIndex>(N))
    throw std::invalid_argument(fmt::format("its {} has not {} numbers", key, N));
  Eigen::Matrix<double, N, 1> numbers;
  for (Json::ArrayIndex i = 0; i < list.size(); ++i) {
    if (!list[i].isNumeric()) throw std::invalid_argument(fmt::format("its {} is not of numbers", key));
    numbers[static_cast<Eigen::Index>(i)] = list[i].asDouble();
  }
  if (!numbers.allFinite()) throw std::invalid_argument(fmt::format("its {} is not finite", key));
  return numbers;
}

Eigen::Isometry3d poseOf(const Json::Value& pose) {
  constexpr double kUnit = 1e-2;  // by which the length of a rounded quaternion may differ
  if (!pose.isObject()) throw std::invalid_argument("its pose is no object of position and quaternion");
  const Eigen::Quaterniond q(numbersOf<4>(pose, "quaternion"));
  if (!(std::abs(q.norm() - 1) < kUnit)) throw std::invalid_argument("its quaternion is no rotation");
  Eigen::Isometry3d T(q.normalized());
  T.translation() = numbersOf<3>(pose, "position");
  return T;
}

Eigen::Isometry3d between(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double share) {
  const Eigen::Quaterniond q_a(a.linear()), q_b(b.linear());
  Eigen::Isometry3d T(q_a.slerp(share, q_b));
  T.translation() = (1 - share) * a.translation() + share * b.translation();
  return T;
}

}  // namespace

OdometryLine parseOdometry(const std::string& line, const std::optional<CameraMounting>& mounting) {
  Json::CharReaderBuilder builder;
  Json::CharReaderBuilder::strictMode(&builder.settings_);
  const std::unique_ptr<Json::CharReader> reader(builder.newCharReader());
  Json::Value value;
  std::string errors;
  bool is_json = false;
  try {
    is_json = reader->parse(line.data(), line.data() + line.size(), &value, &errors);
  } catch (const std::exception&) {  // nested too deeply
  }
  if (!is_json || !value.isObject()) throw std::invalid_argument("it is no JSON object");
  OdometryLine odometry;
  const Json::Value& stamp = value["stamp"];
  if (!stamp.isNull()) {
    if (!stamp.isNumeric() || !std::isfinite(stamp.asDouble()))
      throw std::invalid_argument("its stamp is no number");
    odometry.stamp = stamp.asDouble();
  }
  if (const Json::Value& camera = value["T_w_c"]; !camera.isNull()) {
    odometry.T_o_c = poseOf(camera);
  } else if (const Json::Value& base = value["T_w_b"]; !base.isNull()) {
    if (!mounting)
      throw std::invalid_argument("T_w_b needs the mounting of the camera on the robot, in its camera.ini");
    odometry.T_o_c = poseOf(base) * mounting->T_b_c();
  } else {
    throw std::invalid_argument("it has neither T_w_b nor T_w_c");
  }
  return odometry;
}

OdometryInput::OdometryInput(const std::string& file, const std::optional<CameraMounting>& mounting)
    : name_(file == "-" ? "standard input" : file), mounting_(mounting) {
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
  thread_.join();
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
    if (text.size() > kLongestLine) text.clear();  // what is left of it is no line either
  }
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  arrived_.notify_all();
}

void OdometryInput::take(const std::string& line) {
  const double now = sinceStart(Clock::now());
  if (line.find_first_not_of(" \t\r") == std::string::npos) return;
  std::unique_lock lock(mutex_);
  ++lines_;
  lock.unlock();
  try {
    const OdometryLine odometry = parseOdometry(line, mounting_);
    lock.lock();
    add(odometry, now);
    latest_ = Clock::now();
  } catch (const std::exception& e) {
    if (!lock) lock.lock();
    if (!has_fault_) fault_ = fmt::format("{}: line {} is no odometry: {}", name_, lines_, e.what());
    has_fault_ = true;
    return;
  }
  lock.unlock();
  arrived_.notify_all();
}

void OdometryInput::add(const OdometryLine& line, double now) {
  const bool is_stamped = line.stamp.has_value();
  if (!is_stamped_) is_stamped_ = is_stamped;
  if (*is_stamped_ != is_stamped)
    throw std::invalid_argument(is_stamped ? "it has a stamp, unlike the first one"
                                           : "it has no stamp, unlike the first one");
  const double time = is_stamped ? *line.stamp : now;
  if (!poses_.empty() && !(time >= poses_.back().time)) poses_.clear();  // it begins anew
  poses_.push_back({time, line.T_o_c});
  while (poses_.size() > kMostPoses || poses_.front().time < time - kKept) poses_.pop_front();
}

std::optional<Eigen::Isometry3d> OdometryInput::at(double stamp, Clock::time_point arrival) {
  std::unique_lock lock(mutex_);
  const auto time = [&] { return is_stamped_ && *is_stamped_ ? stamp : sinceStart(arrival); };
  const bool may_come = !ended_ && Clock::now() - latest_ < kSilence;
  arrived_.wait_for(lock, kPatience, [&] {
    return !may_come || stops_ || ended_ || (!poses_.empty() && poses_.back().time >= time());
  });
  const double when = time();
  const auto after = std::lower_bound(poses_.begin(), poses_.end(), when,
                                      [](const Pose& pose, double t) { return pose.time < t; });
  if (after == poses_.end()) return {};
  if (after->time == when) return after->T_o_c;
  if (after == poses_.begin()) return {};
  const Pose &a = *std::prev(after), &b = *after;
  if (b.time - a.time > kLongestStep) return {};
  return between(a.T_o_c, b.T_o_c, (when - a.time) / (b.time - a.time));
}

std::string OdometryInput::fault() {
  const std::lock_guard lock(mutex_);
  return std::exchange(fault_, {});
}

}  // namespace facetloc
