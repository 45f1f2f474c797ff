// SPDX-License-Identifier: BSD-3-Clause
#include "live/live_session.h"

#include "base/text.h"
#include "cli/progress.h"
#include "cli/text.h"

#include <algorithm>
#include <chrono>
#include <fmt/format.h>
#include <stdexcept>
#include <utility>

namespace facetloc {
namespace {

using Clock = LatestFrame<LiveFrame>::Clock;
using std::chrono::milliseconds;

constexpr milliseconds kWakeUp(100);         // to look whether something else is to be done
constexpr milliseconds kNap(10);             // between looks whether the pause is over
constexpr double kUsualInterval = 1.0 / 30;  // [s]

}  // namespace

std::string LiveSummary::text() const {
  std::string words =
      fmt::format("{} received, {} processed, {} dropped", counted(received, "frame"), processed, dropped());
  if (processed == 0) return words;
  const auto n = static_cast<double>(processed);
  if (seconds > 0) words += fmt::format(", {:.1f}/s", (n - 1) / seconds);
  words += fmt::format(", {:.1f} ms each, none older than {:.0f} ms", processing_ms / n, oldest_ms);
  std::string shares;
  for (const auto& [state, count] : states)
    shares +=
        fmt::format("{}{} {:.1f} %", shares.empty() ? "" : ", ", state, 100 * static_cast<double>(count) / n);
  if (with_odometry > 0)
    shares += fmt::format(", with odometry {:.1f} %", 100 * static_cast<double>(with_odometry) / n);
  return words + "; " + shares;
}

LiveSession::LiveSession(const LiveSessionOptions& options, std::shared_ptr<const Map> map,
                         OnResult on_result)
    : options_(options),
      map_(std::move(map)),
      on_result_(std::move(on_result)),
      builder_(options.camera, options.view) {
  if (map_) {
    localizer_ = std::make_unique<Localizer>(map_, options.localizer, options.localization);
    localizer_->setNumberOfThreads(options.threads);
    localizer_->setMinProbability(options.min_probability);
    if (options.start) localizer_->setPose(*options.start);
  }
  thread_ = std::thread([this] { run(); });
}

LiveSession::~LiveSession() {
  abandoned_ = true;
  end();
}

void LiveSession::end() {
  mailbox_.close();
  paused_ = false;
  if (thread_.joinable()) thread_.join();
  mailbox_.clear();  // a frame may be a buffer of a driver that is about to go
}

void LiveSession::letGo(const std::function<void()>& meanwhile) {
  mailbox_.clear();
  // A frame taken in the present round is done when the next one begins.
  for (const std::uint64_t round = rounds_; !done_ && rounds_ == round; std::this_thread::sleep_for(kNap))
    if (meanwhile) meanwhile();
}

void LiveSession::finish(const std::function<void()>& meanwhile) {
  mailbox_.close();
  paused_ = false;
  for (; meanwhile && !done_; std::this_thread::sleep_for(kNap)) meanwhile();
  end();
  if (error_) std::rethrow_exception(error_);
}

void LiveSession::run() try {
  while (!abandoned_) {
    ++rounds_;
    if (paused_) {
      std::this_thread::sleep_for(kNap);
      continue;
    }
    const auto arrived = mailbox_.take(kWakeUp);  // the pause may have begun in here
    if (arrived && mayProcess(*arrived)) process(*arrived);
    if (options_.max_frames > 0 && summary_.processed >= options_.max_frames) break;
    if (!arrived && mailbox_.closed() && !mailbox_.counts().waiting) break;
  }
  mailbox_.close();
  done_ = true;
} catch (...) {
  error_ = std::current_exception();
  mailbox_.close();
  done_ = true;
}

bool LiveSession::mayProcess(const LatestFrame<LiveFrame>::Arrived& arrived) const {
  if (options_.every_frame) return true;
  return !paused_ && millisecondsSince(arrived.arrival) <= options_.oldest_frame_ms;
}

/** A recording that is repeated begins again: its time goes on, but the camera is somewhere else. */
double LiveSession::increasingStamp(double stamp) {
  if (summary_.processed > 0 && stamp + stamp_offset_ <= last_stamp_) {
    stamp_offset_ = last_stamp_ + kUsualInterval - stamp;
    relocalize_ = true;
    steps_.reset();
  }
  return last_stamp_ = stamp + stamp_offset_;
}

/** Since the frame before, if it is known where the camera was then, and is now. */
std::optional<Eigen::Isometry3d> LiveSession::motionSince(const LatestFrame<LiveFrame>::Arrived& arrived) {
  if (!options_.odometry) return {};
  return steps_.to(options_.odometry->at(arrived.frame.stamp, arrived.arrival));
}

/** Applies the robot's lines about the present pose of the camera. */
void LiveSession::obeyRobot() {
  if (!options_.odometry) return;
  if (options_.odometry->takeRelocalize()) localizer_->reset();
  const std::optional<NumberedStart> line = options_.odometry->takeStart();
  if (!line) return;
  const std::vector<std::string>& parts = map_->parts;
  const auto part = std::find(parts.begin(), parts.end(), line->start.part);
  try {
    if (part == parts.end() && !(parts.empty() && line->start.part.empty()))
      throw std::invalid_argument("the map has no part '" + line->start.part + "'");
    localizer_->setPose(line->start.T_w_c, static_cast<int>(part - parts.begin()));
  } catch (const std::invalid_argument& e) {
    options_.odometry->refuse(*line, std::string("its pose cannot be used: ") + e.what());
  }
}

void LiveSession::process(const LatestFrame<LiveFrame>::Arrived& arrived) {
  auto result = std::make_shared<LiveResult>();
  result->age_ms = millisecondsSince(arrived.arrival);
  const Clock::time_point start = Clock::now();
  const DepthImage full = arrived.frame.image();
  result->stamp = increasingStamp(arrived.frame.stamp);
  result->image = see(text::decimals(result->stamp, 6), workingImage(full, options_.width), builder_,
                      arrived.frame.gravity);
  result->segment_ms = builder_.segmentMilliseconds();
  result->features_ms = builder_.featuresMilliseconds();
  const std::optional<Eigen::Isometry3d> motion = motionSince(arrived);
  result->has_odometry = motion.has_value();
  if (localizer_) {
    if (relocalize_.exchange(false)) localizer_->reset();
    obeyRobot();
    const Clock::time_point begin = Clock::now();
    std::optional<PoseWithCovariance> measured;
    if (motion) measured = motionByOdometry(*motion, builder_.camera().mounting, options_.odometry_error);
    result->answer = localizer_->update(result->image.view, result->stamp, measured);
    result->localize_ms = millisecondsSince(begin);
    if (result->isLocalized() && result->pose())
      trajectory_.add(result->pose()->T.translation(), result->part());
    else
      trajectory_.interrupt();
    result->trajectory = trajectory_;
  }
  if (options_.mapping) {
    if (relocalize_.exchange(false)) options_.mapping->interrupt();
    if (options_.odometry && options_.odometry->takeRelocalize()) options_.mapping->interrupt();
    if (const auto line = options_.odometry ? options_.odometry->takeStart() : std::nullopt)
      options_.odometry->refuse(*line, "a pose needs --map");
    const Clock::time_point begin = Clock::now();
    result->mapped = options_.mapping->update(result->image.view, result->image.name, result->stamp, motion);
    result->localize_ms = millisecondsSince(begin);
    result->trajectory = result->mapped->trajectory;
  }
  const auto counts = mailbox_.counts();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (summary_.processed == 0) first_ = arrived.arrival;
    last_ = arrived.arrival;
    ++summary_.processed;
    ++summary_.states[result->state()];
    summary_.with_odometry += result->has_odometry;
    summary_.oldest_ms = std::max(summary_.oldest_ms, result->age_ms);
    result->number = summary_.processed;
    result->received = counts.received;
    result->dropped = counts.received - summary_.processed - counts.waiting;
  }
  on_result_(result);
  const std::lock_guard<std::mutex> lock(mutex_);
  summary_.processing_ms += millisecondsSince(start);
}

LiveSummary LiveSession::summary() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  LiveSummary summary = summary_;
  summary.received = mailbox_.counts().received;
  summary.seconds = std::chrono::duration<double>(last_ - first_).count();
  return summary;
}

}  // namespace facetloc
