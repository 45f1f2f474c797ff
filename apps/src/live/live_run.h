// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/stop_signal.h"
#include "drawing/offscreen_display.h"
#include "live/live_extension.h"
#include "live/live_picture.h"
#include "live/live_results.h"
#include "live/live_session.h"
#include "live/live_status.h"
#include "live/live_window.h"
#include "live/remembered_pose.h"
#include "outputs/pose_stream.h"

#include <facetloc/io/oni_recorder.h>
#include <facetloc/mapping/map_builder.h>
#include <facetloc/mapping/trajectory_estimation.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <ostream>
#include <string>

namespace facetloc {

/** \brief The options of a live run. */
struct LiveRunOptions {
  LiveSourceOptions source;
  std::string map;          ///< file; empty = segmentation only
  std::string build;        ///< file of a map to be made; empty = none
  std::string extend;       ///< the map itself, if it is to be brought up to date; empty = it stays
  std::string remember;     ///< file of the last sure pose; empty = none
  std::string results;      ///< folder; empty = none
  std::string screenshots;  ///< folder; empty = none
  std::string recording;    ///< file; empty = none
  std::string odometry;     ///< file, "-" = standard input; empty = none
  std::string near;         ///< where the camera begins (startPose()); empty = not known
  int every = 30;           ///< processed frames per screenshot
  bool headless = false;
  bool wait = false;  ///< for a device that is not there, or has gone
  int max_frames = 0;
  double duration = 0;             ///< [s]; 0 = without end
  std::ostream* stream = nullptr;  ///< answers go here, as lines of JSON (PoseStream); null = nowhere
};

/** \brief The parameters of a live run's algorithms, for a camera that is not known yet. */
struct LiveAlgorithms {
  std::function<Camera(const std::optional<CameraFile>&)> camera;
  LiveSessionOptions session;             // but for its camera, its map, and the one that it makes
  std::optional<double> min_probability;  // none = as the map was calibrated
  MappingParams mapping;
  MapBuilderParams places;
};

/** \brief A live run from its begin to its end: opens the source, again if it has to, and does on one thread
 * all that is not done by the processing thread of the session: window, screenshots, and whether it is time
 * to end. */
class LiveRun {
public:
  LiveRun(const LiveRunOptions& options, LiveAlgorithms algorithms, const Console& console);
  ~LiveRun();
  LiveRun(const LiveRun&) = delete;
  LiveRun& operator=(const LiveRun&) = delete;

  /** \brief Runs until the end. Throws the first exception of any thread, after all was written. */
  void run();
  /** \brief The outcome on one line. */
  std::string summary() const;

private:
  using Clock = std::chrono::steady_clock;

  void tellThatItWaits(const std::string& cause);
  bool openSource();
  void startSource();
  void closeSource();
  void pause() const;
  void startSession();
  void rememberPose(const std::optional<CameraMounting>& mounting);
  void listenToRobot(const std::optional<CameraMounting>& mounting);
  void startMapping(const Camera& camera);
  void finish();
  void receive(const LiveResultPtr& result);
  bool stopAsked() const;
  bool timeIsUp() const;
  bool sourceEnded() const;
  std::string sourceProblem() const;
  void tellWhatIsMissing();
  void loop();
  void tellFaultsOfRobot();
  void tick();
  void obey(LiveCommand command);
  void drawWindow();
  void drawScreenshots();
  void drawScreenshot(const LiveResult& result, const std::filesystem::path& path);
  void startRecording(const std::filesystem::path& file);
  void stopRecording();

  const LiveRunOptions options_;
  LiveAlgorithms algorithms_;
  const Console& console_;
  StopSignal stop_;
  bool quit_ = false;
  std::optional<std::uint64_t> told_at_;  // frames received when it was last told that it waits
  std::shared_ptr<const Map> map_;
  std::shared_ptr<LiveMapping> mapping_;
  std::shared_ptr<OdometryInput> odometry_;
  std::optional<OffscreenDisplay> display_;
  std::optional<Clock::time_point> begin_;  // when the first source was opened, or first waited for
  Clock::time_point source_start_;

  // Frames go from the source to the session, and results from there to the mailboxes.
  std::shared_ptr<PipeFrames> pipe_;  // standard input, as far as it has been read
  std::unique_ptr<LiveSource> source_;
  std::unique_ptr<OniRecorder> recorder_;
  std::filesystem::path recording_;  // its file
  std::unique_ptr<LiveResults> results_;
  std::unique_ptr<PoseStream> stream_;
  std::unique_ptr<RememberedPose> remembered_;
  std::unique_ptr<LiveExtension> extension_;
  LatestFrame<LiveResultPtr> newest_, to_draw_;
  std::unique_ptr<LiveSession> session_;

  LiveStatus status_;
  FrameRate rate_;
  LiveResultPtr shown_;
  std::unique_ptr<LiveWindow> window_;
  std::unique_ptr<LiveScreenshot> screenshot_;
  Clock::time_point next_draw_;  // next time to draw the window
  std::size_t screenshots_ = 0;
};

}  // namespace facetloc
