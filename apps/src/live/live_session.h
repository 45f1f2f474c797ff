// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/odometry_steps.h"
#include "live/latest_frame.h"
#include "live/live_mapping.h"
#include "live/live_result.h"
#include "live/live_source.h"
#include "live/odometry_input.h"

#include <facetloc/localization/localizer.h>
#include <facetloc/registration/pose_prior.h>
#include <facetloc/segmentation/view_builder.h>

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

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
  std::uint64_t max_frames = 0;  ///< number of processed frames after which the run ends; 0 = never
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
  std::string text() const;
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
  LiveSession(const LiveSessionOptions& options, std::shared_ptr<const Map> map, OnResult on_result);
  /** \brief Ends the thread; the frame in the mailbox is not processed. */
  ~LiveSession();
  LiveSession(const LiveSession&) = delete;
  LiveSession& operator=(const LiveSession&) = delete;

  /** \brief Where a source puts its frames. */
  LatestFrame<LiveFrame>& mailbox() { return mailbox_; }

  /** \brief When it returns, no frame is held any more that came before: their source can be destroyed.
   * \param meanwhile is called while it waits, for callbacks that the processing thread may wait for. */
  void letGo(const std::function<void()>& meanwhile = {});

  /** \brief While paused, frames are received and dropped. */
  void setPaused(bool paused) { paused_ = paused; }
  bool paused() const { return paused_; }
  /** \brief The next frame is searched in the whole map. */
  void relocalize() { relocalize_ = true; }

  /** \brief Has the thread ended: enough frames, or an exception? */
  bool done() const { return done_; }
  /** \brief Takes no more frames, processes the waiting one, ends the thread, and rethrows its exception.
   * \param meanwhile as letGo()'s */
  void finish(const std::function<void()>& meanwhile = {});
  LiveSummary summary() const;

private:
  void run();
  bool mayProcess(const LatestFrame<LiveFrame>::Arrived& arrived) const;
  void process(const LatestFrame<LiveFrame>::Arrived& arrived);
  double increasingStamp(double stamp);
  std::optional<Eigen::Isometry3d> motionSince(const LatestFrame<LiveFrame>::Arrived& arrived);
  void obeyRobot();
  void end();

  const LiveSessionOptions options_;
  std::shared_ptr<const Map> map_;
  OnResult on_result_;
  LatestFrame<LiveFrame> mailbox_;
  ViewBuilder builder_;
  std::unique_ptr<Localizer> localizer_;
  LiveTrajectory trajectory_;
  double last_stamp_ = 0, stamp_offset_ = 0;
  internal::OdometrySteps steps_;
  LatestFrame<LiveFrame>::Clock::time_point first_, last_;  // arrivals of processed frames

  std::atomic<std::uint64_t> rounds_{0};
  std::atomic<bool> paused_{false}, relocalize_{false}, abandoned_{false}, done_{false};
  mutable std::mutex mutex_;  // guards the summary and the error
  LiveSummary summary_;
  std::exception_ptr error_;
  std::thread thread_;  // the last member: it uses all others
};

}  // namespace facetloc
