// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/odometry_steps.h"
#include "base/text.h"
#include "cli/progress.h"
#include "cli/text.h"
#include "live/latest_frame.h"
#include "live/live_mapping.h"
#include "live/live_result.h"
#include "live/live_source.h"
#include "live/odometry_input.h"

#include <facetloc/localization/localizer.h>
#include <facetloc/registration/pose_prior.h>
#include <facetloc/segmentation/view_builder.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <fmt/format.h>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

namespace facetloc {

struct LiveSessionOptions {
  int width = 320;  ///< working width [px]; 0 = full size
  Camera camera;
  ViewParams view;
  LocalizerParams localizer;
  OdometryError odometry_error;
  double min_probability = kMinProbability;  ///< least probability of a sure place
  std::optional<PoseWithCovariance> start;   ///< where the camera is when it begins, as far as that is known
  GlobalLocalizationParams localization;
  std::shared_ptr<LiveMapping> mapping;     ///< if a map is to be made
  std::shared_ptr<OdometryInput> odometry;  ///< odometry of the robot; null without one
  int threads = 0;                          ///< threads of global localization; 0 = all cores
  int max_frames = 0;            ///< number of processed frames after which the run ends; 0 = never
  double oldest_frame_ms = 100;  ///< age above which a frame is dropped when its turn comes
  bool every_frame = false;      ///< none is dropped: the next one comes when this one is done
};

/** \brief The outcome of a live run. */
struct LiveSummary {
  std::uint64_t received = 0, processed = 0;
  std::map<std::string, std::uint64_t> states;  ///< processed frames by state
  std::uint64_t with_odometry = 0;              ///< processed frames whose motion an odometry has measured
  double processing_ms = 0;                     ///< sum over the processed frames
  double oldest_ms = 0;                         ///< largest age of a frame when its processing began
  double seconds = 0;                           ///< time between the first frame and the last one

  std::uint64_t dropped() const { return received - processed; }
  /** \brief Several sentences on one line. */
  std::string text() const {
    std::string words = fmt::format("{} received, {} processed, {} dropped", counted(received, "frame"),
                                    processed, dropped());
    if (processed == 0) return words;
    const auto n = static_cast<double>(processed);
    if (seconds > 0) words += fmt::format(", {:.1f}/s", (n - 1) / seconds);
    words += fmt::format(", {:.1f} ms each, none older than {:.0f} ms", processing_ms / n, oldest_ms);
    std::string shares;
    for (const auto& [state, count] : states)
      shares += fmt::format("{}{} {:.1f} %", shares.empty() ? "" : ", ", state,
                            100 * static_cast<double>(count) / n);
    if (with_odometry > 0)
      shares += fmt::format(", with odometry {:.1f} %", 100 * static_cast<double>(with_odometry) / n);
    return words + "; " + shares;
  }
};

/** \brief The processing thread of a live run: takes the newest frame, segments it, and follows the camera in
 * the map, or makes one.
 *
 * A frame that has grown old when its turn comes is dropped: the picture shows the present. */
class LiveSession {
public:
  using OnResult = std::function<void(const LiveResultPtr&)>;

  /** \param map may be null: segmentation only. \param on_result is called by the processing thread after
   * each frame; if it throws, the session ends and finish() throws the same. */
  LiveSession(const LiveSessionOptions& options, std::shared_ptr<const Map> map, OnResult on_result)
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

  /** \brief Ends the thread; the frame in the mailbox is not processed. */
  ~LiveSession() {
    abandoned_ = true;
    end();
  }

  /** \brief Where a source puts its frames. */
  LatestFrame<LiveFrame>& mailbox() { return mailbox_; }

  /** \brief When it returns, no frame is held any more that came before: their source can be destroyed.
   * \param meanwhile is called while it waits, for callbacks that the processing thread may wait for. */
  void letGo(const std::function<void()>& meanwhile = {}) {
    mailbox_.clear();
    // A frame taken in the present round is done when the next one begins.
    for (const std::uint64_t round = rounds_; !done_ && rounds_ == round; std::this_thread::sleep_for(kNap))
      if (meanwhile) meanwhile();
  }

  /** \brief While paused, frames are received and dropped. */
  void setPaused(bool paused) { paused_ = paused; }
  bool paused() const { return paused_; }
  /** \brief The next frame is searched in the whole map. */
  void relocalize() { relocalize_ = true; }

  /** \brief Has the thread ended: enough frames, or an exception? */
  bool done() const { return done_; }
  /** \brief Takes no more frames, processes the waiting one, ends the thread, and rethrows its exception.
   * \param meanwhile as letGo()'s */
  void finish(const std::function<void()>& meanwhile = {}) {
    mailbox_.close();
    paused_ = false;
    for (; meanwhile && !done_; std::this_thread::sleep_for(kNap)) meanwhile();
    end();
    if (error_) std::rethrow_exception(error_);
  }

  LiveSummary summary() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    LiveSummary summary = summary_;
    summary.received = mailbox_.counts().received;
    summary.seconds = std::chrono::duration<double>(last_ - first_).count();
    return summary;
  }

private:
  using Clock = LatestFrame<LiveFrame>::Clock;
  using Arrived = LatestFrame<LiveFrame>::Arrived;
  using milliseconds = std::chrono::milliseconds;
  static constexpr milliseconds kWakeUp{100};         // to look whether something else is to be done
  static constexpr milliseconds kNap{10};             // between looks whether the pause is over
  static constexpr double kUsualInterval = 1.0 / 30;  // [s]

  void run() try {
    while (!abandoned_) {
      ++rounds_;
      if (paused_) {
        std::this_thread::sleep_for(kNap);
        continue;
      }
      const auto arrived = mailbox_.take(kWakeUp);  // the pause may have begun in here
      if (arrived && (options_.every_frame ||
                      (!paused_ && millisecondsSince(arrived->arrival) <= options_.oldest_frame_ms)))
        process(*arrived);
      if (options_.max_frames > 0 && summary_.processed >= static_cast<std::uint64_t>(options_.max_frames))
        break;
      if (!arrived && mailbox_.closed() && !mailbox_.counts().waiting) break;
    }
    mailbox_.close();
    done_ = true;
  } catch (...) {
    error_ = std::current_exception();
    mailbox_.close();
    done_ = true;
  }

  void process(const Arrived& arrived) {
    auto result = std::make_shared<LiveResult>();
    result->age_ms = millisecondsSince(arrived.arrival);
    const Clock::time_point start = Clock::now();
    const DepthImage full = arrived.frame.image();
    result->stamp = increasingStamp(arrived.frame.stamp);
    result->image = see(text::decimals(result->stamp, 6), workingImage(full, options_.width), builder_,
                        arrived.frame.gravity);
    result->segment_ms = builder_.segmentMilliseconds();
    result->features_ms = builder_.featuresMilliseconds();
    std::optional<Eigen::Isometry3d> motion;  // since the frame before, if both places are known
    if (options_.odometry) motion = steps_.to(options_.odometry->at(arrived.frame.stamp, arrived.arrival));
    result->has_odometry = motion.has_value();
    if (localizer_) {
      if (relocalize_.exchange(false)) localizer_->reset();
      obeyRobot();
      const Clock::time_point begin = Clock::now();
      std::optional<PoseWithCovariance> measured;
      if (motion) measured = motionByOdometry(*motion, builder_.camera().mounting, options_.odometry_error);
      result->answer = localizer_->update(result->image.view, result->stamp, measured);
      advise(result->image.view, *result->answer);
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
      result->mapped =
          options_.mapping->update(result->image.view, result->image.name, result->stamp, motion);
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

  /** A recording that is repeated begins again: its time goes on, but the camera is somewhere else. */
  double increasingStamp(double stamp) {
    if (summary_.processed > 0 && stamp + stamp_offset_ <= last_stamp_) {
      stamp_offset_ = last_stamp_ + kUsualInterval - stamp;
      relocalize_ = true;
      steps_.reset();
    }
    return last_stamp_ = stamp + stamp_offset_;
  }

  /** Where to look next: the advice of the latest search that has left the place open, less the turn since.
   */
  void advise(const View& view, Localization& answer) {
    const Eigen::Vector3d turned = logSO3(answer.T_before_now.T.linear());
    const auto& mounting = builder_.camera().mounting;
    if (answer.state == AnswerState::sure)
      next_look_.reset();
    else if (answer.searched)
      next_look_ = localizer_->nextLook(view, answer);
    else if (next_look_)
      next_look_->yaw -= mounting ? (mounting->T_b_c().linear() * turned).z() : -turned.y();
    answer.next_look = next_look_;
  }

  /** Applies the robot's lines about the present pose of the camera. */
  void obeyRobot() {
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

  void end() {
    mailbox_.close();
    paused_ = false;
    if (thread_.joinable()) thread_.join();
    mailbox_.clear();  // a frame may be a buffer of a driver that is about to go
  }

  const LiveSessionOptions options_;
  std::shared_ptr<const Map> map_;
  OnResult on_result_;
  LatestFrame<LiveFrame> mailbox_;
  ViewBuilder builder_;
  std::unique_ptr<Localizer> localizer_;
  LiveTrajectory trajectory_;
  double last_stamp_ = 0, stamp_offset_ = 0;
  internal::OdometrySteps steps_;
  std::optional<NextLook> next_look_;  // while the place is open
  Clock::time_point first_, last_;     // arrivals of processed frames

  std::atomic<std::uint64_t> rounds_{0};
  std::atomic<bool> paused_{false}, relocalize_{false}, abandoned_{false}, done_{false};
  mutable std::mutex mutex_;  // guards the summary and the error
  LiveSummary summary_;
  std::exception_ptr error_;
  std::thread thread_;  // the last member: it uses all others
};

}  // namespace facetloc
