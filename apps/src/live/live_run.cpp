// SPDX-License-Identifier: BSD-3-Clause
#include "live/live_run.h"

#include "base/text.h"
#include "cli/findings_file.h"
#include "cli/progress.h"
#include "cli/text.h"
#include "drawing/offscreen_display.h"
#include "inputs/depth_input.h"
#include "inputs/localization_options.h"
#include "live/live_extension.h"
#include "live/live_findings.h"
#include "live/live_picture.h"
#include "live/live_results.h"
#include "live/live_status.h"
#include "live/live_window.h"
#include "live/remembered_pose.h"
#include "outputs/output_folder.h"
#include "outputs/pose_stream.h"

#include <facetloc/features/map_metadata.h>
#include <facetloc/io/error.h>
#include <facetloc/io/map_database.h>
#include <facetloc/io/oni_file.h>
#include <facetloc/openni/openni_grabber.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <set>
#include <stdexcept>
#include <thread>

namespace facetloc {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds, std::chrono::seconds;

constexpr seconds kStall(3);              // without a frame
constexpr milliseconds kRetry(1000);      // between looks for a device
constexpr milliseconds kTick(20);         // between looks whether something has happened
constexpr milliseconds kLastFrames(250);  // wait after the end of a file for frames still under way

/** A fault of the source, not of the processing of its frames: waiting may help. */
class SourceError : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/** The file itself or, if it is there already, the first of file-2, file-3, ... that is not. */
fs::path unused(const fs::path& file) {
  fs::path name = file;
  for (int n = 2; fs::exists(name); ++n)
    name = file.parent_path() / fmt::format("{}-{}{}", file.stem().string(), n, file.extension().string());
  return name;
}

std::vector<std::string> fileNames(const std::vector<std::string>& paths) {
  std::vector<std::string> names;
  for (const std::string& path : paths) names.push_back(fs::path(path).filename().string());
  return names;
}

/** Opens the source, again if it has to, and does on one thread all that is not done by the processing thread
 * of the session: window, screenshots, and whether it is time to end. */
class LiveRun {
public:
  LiveRun(const LiveRunOptions& options, const Console& console)
      : options_(options), console_(console), status_(console) {
    if (!options_.maps.empty()) {
      map_ = openMaps(options_.maps, console_);
      options_.session.min_probability = minProbabilityOf(*map_);
    }
    if (options_.min_probability) options_.session.min_probability = *options_.min_probability;
    if (!options_.headless) {
      if (!displayUsable())
        throw std::runtime_error("no X server can be reached (DISPLAY); without a window: --headless");
      display_.emplace();
    } else if (!options_.screenshots.empty()) {
      display_.emplace();
      if (!display_->available()) throw std::runtime_error("no screenshots: " + display_->problem());
    }
  }

  ~LiveRun() {
    recorder_.reset();
    to_draw_.close();
    closeSource();
  }

  /** Runs until the end. Throws the first exception of any thread, after all was written. */
  void run() {
    while (openSource()) {
      if (!begin_) begin_ = Clock::now();
      if (!session_) startSession();
      try {
        startSource();
        if (!options_.recording.empty())
          startRecording(recording_.empty() ? fs::path(options_.recording) : unused(options_.recording));
        loop();
        break;
      } catch (const SourceError& e) {
        status_.clear();
        if (!options_.wait || source_->isPipe()) {
          closeSource();
          finish();
          throw;
        }
        tellThatItWaits(e.what());
        closeSource();
        pause();
      }
    }
    if (source_) stopRecording(), source_->stop();
    finish();
    status_.clear();
  }

  /** The outcome on one line. */
  std::string summary() const {
    if (!session_) return "no device, no frames";
    std::string words = session_->summary().text();
    if (mapping_) words += "; mapped " + mapping_->state().toString();
    if (!options_.results.empty()) words += "; results in " + options_.results;
    if (!options_.screenshots.empty())
      words += fmt::format("; {} in {}", counted(screenshots_, "screenshot"), options_.screenshots);
    if (const auto late = to_draw_.counts().dropped)
      words += fmt::format(" ({} left out, as drawing took too long)", late);
    return words;
  }

private:
  using Clock = std::chrono::steady_clock;

  void note(const std::string& text) {
    status_.clear();
    console_.note(text);
  }

  /** Once for each kind, however often the source is opened again. */
  void find(const Finding& finding) {
    if (!found_.insert(finding.id).second) return;
    status_.clear();
    console_.find(finding);
    if (finding.severity != Severity::note)
      doubt_ = std::string(toString(finding.severity)) + ": " + finding.text();
  }

  /** Once for each time that something is missing. */
  void tellThatItWaits(const std::string& cause) {
    const std::uint64_t received = session_ ? session_->mailbox().counts().received : 0;
    if (received == told_at_) return;
    told_at_ = received;
    status_.clear();
    console_.error(cause + "; waiting for it");
  }

  /** \return false if the user does not want to wait any more. */
  bool openSource() {
    if (!pipe_) pipe_ = LiveSource::pipeOf(options_.source);
    while (!stopAsked() && !timeIsUp()) {
      try {
        source_ = std::make_unique<LiveSource>(options_.source, pipe_);
        for (const Finding& finding : source_->findings()) find(finding);
        return true;
      } catch (const IoError& e) {
        if (!options_.wait || (pipe_ && (pipe_->hasFailed() || pipe_->atEnd()))) throw;
        if (!begin_) begin_ = Clock::now();  // to wait takes of the time that it has
        tellThatItWaits(e.what());
      }
      pause();
    }
    return false;
  }

  /** Until it makes sense to look for a device again. */
  void pause() const {
    for (const auto end = Clock::now() + kRetry; Clock::now() < end && !stopAsked() && !timeIsUp();)
      std::this_thread::sleep_for(kTick);
  }

  void startSource() try {
    source_->start([this](LiveFrame frame) { session_->mailbox().put(std::move(frame)); });
    source_start_ = Clock::now();
  } catch (const IoError& e) {
    throw SourceError(e.what());
  }

  void closeSource() {
    if (!source_) return;
    stopRecording();
    source_->stop();
    if (session_) session_->letGo([this] { drawScreenshots(); });
    source_.reset();
  }

  void startMapping(const Camera& camera) {
    const std::string parameters = fmt::format("width = {}\n", options_.session.width) +
                                   toIni(camera.noise, "noise") + toIni(options_.session.view) +
                                   toIni(options_.mapping, "mapping") + toIni(options_.places, "map");
    mapping_ =
        std::make_shared<LiveMapping>(options_.build, camera, options_.mapping, options_.places, parameters);
  }

  /** Finishes the run when no frame comes any more. */
  void finish() {
    if (!session_) return;
    session_->finish([this] { drawScreenshots(); });
    if (findings_) findings_->finish();
    tick();  // the last screenshot
    if (!options_.results.empty() && console_.findings)
      writeFindings(fs::path(options_.results) / kFindingsFile, *console_.findings);
    if (mapping_) mapping_->finish();
  }

  /** The pose remembered from an earlier run is a start like one of the robot, unless the user gives one. */
  void rememberPose(const std::optional<CameraMounting>& mounting) try {
    if (options_.remember.empty()) return;
    remembered_ = std::make_unique<RememberedPose>(options_.remember, map_, mounting);
    const std::string line = options_.near.empty() ? remembered_->start() : "";
    if (!line.empty()) odometry_->take(line);
  } catch (const IoError& e) {
    console_.note(e.what());
  }

  /** Its lines come as --odometry says, and with the frames that a program sends. */
  void listenToRobot(const std::optional<CameraMounting>& mounting) {
    if (options_.odometry.empty() && options_.remember.empty() && !pipe_) return;
    odometry_ = std::make_shared<OdometryInput>(options_.odometry, mounting);
    if (pipe_) pipe_->setLines([lines = odometry_](const std::string& line) { lines->take(line); });
  }

  /** Now that the camera is known. */
  void startSession() {
    LiveSessionOptions options = options_.session;
    options.camera = options_.camera(source_->camera());
    options.every_frame = options_.source.every_frame;
    if (map_) {
      options.camera = map_->calibrated(options.camera);
      noteDifference(options.camera, *map_, console_);
    }
    if (!options_.build.empty()) startMapping(options.camera);
    options.mapping = mapping_;
    if (map_) options.start = startPose(options_.near, options.camera.mounting);
    listenToRobot(options.camera.mounting);
    rememberPose(options.camera.mounting);
    if (!options_.extend.empty())
      extension_ = std::make_unique<LiveExtension>(options_.extend, options.camera);
    options.odometry = odometry_;
    if (!options_.results.empty()) {
      const std::string map =
          map_       ? fmt::format(", map {} of {}", fmt::join(fileNames(options_.maps), " and "),
                                   counted(map_->models.size(), "local model"))
          : mapping_ ? ", which makes a map"
                     : ", without a map";
      const std::string params_ini =
          fmt::format("# {}, live from {}{}\nmin-probability = {}\nwidth = {}\n", versionText(),
                      source_->name(), map, text::shortest(options.min_probability), options.width) +
          toIni(options.camera.noise, "noise") + toIni(options.view) + toIni(options.localizer, "localizer") +
          localizationIni(options.localization);
      results_ = std::make_unique<LiveResults>(options_.results, params_ini);
    }
    if (options_.stream) stream_ = std::make_unique<PoseStream>(*options_.stream, options.camera.mounting);
    if (!options_.headless) window_ = std::make_unique<LiveWindow>("facetloc_live " + source_->name(), map_);
    if (!options_.screenshots.empty()) screenshot_ = std::make_unique<LiveScreenshot>(map_);
    if (!options_.source.repeat) findings_ = std::make_unique<LiveFindings>(options.camera);
    session_ = std::make_unique<LiveSession>(options, map_,
                                             [this](const LiveResultPtr& result) { receive(result); });
  }

  /** Called by the processing thread: writes data that must not be lost, leaves the rest to others. */
  void receive(const LiveResultPtr& result) {
    if (extension_) extension_->put(*result);
    if (findings_) findings_->add(result->number, result->image.depth);
    if (results_ || stream_ || remembered_) {
      const FrameResult row = frameResult(*result, map_.get(), options_.session.min_probability);
      if (results_) results_->append(*result, row);
      if (remembered_) remembered_->put(row);
      if (stream_) stream_->put(static_cast<std::size_t>(result->number - 1), row);
    }
    newest_.put(result);
    const bool its_turn = (result->number - 1) % static_cast<std::uint64_t>(options_.every) == 0;
    if (!options_.screenshots.empty() && its_turn)
      source_->isFile() ? to_draw_.putInTurn(result) : to_draw_.put(result);
    source_->next();
  }

  bool stopAsked() const { return quit_ || stop_.raised(); }

  bool timeIsUp() const {
    return begin_ && options_.duration > 0 &&
           Clock::now() - *begin_ >= std::chrono::duration<double>(options_.duration);
  }

  /** Did all frames of a file arrive? */
  bool sourceEnded() const {
    if (!source_->atEnd()) return false;
    const auto last = session_->mailbox().lastArrival();
    return Clock::now() - std::max(last.value_or(source_start_), source_start_) > kLastFrames;
  }

  /** Why no more frames are to be expected; empty if they are. */
  std::string sourceProblem() const {
    if (!source_->connected()) {
      const std::string cause = source_->lastError();
      if (source_->isPipe()) return cause;
      return fmt::format("{}: the device has gone{}", source_->name(),
                         cause.empty() ? "" : " (" + cause + ")");
    }
    if (options_.source.every_frame || (options_.wait && source_->isPipe())) return {};  // one of us waits
    const auto last = session_->mailbox().lastArrival();
    if (Clock::now() - std::max(last.value_or(source_start_), source_start_) <= kStall) return {};
    return fmt::format("{}: no frame for {} s", source_->name(), kStall.count());
  }

  /** Reports missing frames; the source names only the last image that could not be read. */
  void tellWhatIsMissing() {
    const std::string cause = source_->lastError();
    if (sourceEnded() && session_->mailbox().counts().received == 0)
      throw IoError(source_->name(), "ended without a frame" + (cause.empty() ? "" : ": " + cause));
    if (!cause.empty()) note(fmt::format("{}: frames are missing: {}", source_->name(), cause));
  }

  void loop() {
    while (!stopAsked() && !timeIsUp() && !session_->done() && !sourceEnded()) {
      const std::string problem = sourceProblem();
      if (!problem.empty()) throw SourceError(problem);
      if (recorder_ && !recorder_->hasRoom()) {
        stopRecording();
        throw IoError(recording_.string(),
                      "the disk is full: the recording ends here, the images before are kept");
      }
      tick();
      std::this_thread::sleep_for(kTick);
    }
    tellWhatIsMissing();
  }

  void tick() {
    if (odometry_)
      for (std::string fault = odometry_->fault(); !fault.empty(); fault = odometry_->fault()) note(fault);
    if (findings_)
      for (const Finding& finding : findings_->take()) find(finding);
    if (auto newest = newest_.take({})) {
      shown_ = newest->frame;
      rate_.update(shown_->number);
      status_.show(*shown_, rate_.value());
    }
    drawScreenshots();
    if (!window_) return;
    drawWindow();
    for (const LiveCommand command : window_->commands()) {
      try {
        obey(command);
      } catch (const std::exception& e) {  // which is no reason to end the run
        status_.clear();
        console_.error(e.what());
      }
    }
  }

  /** Not more often than leaves half of the time to others, where the processor does the drawing. */
  void drawWindow() {
    const Clock::time_point start = Clock::now();
    if (!shown_ || start < next_draw_) return;
    std::vector<std::string> footer = {timesText(*shown_, rate_.value())};
    if (recorder_)
      footer.front() = fmt::format("RECORDING {},  {}", recording_.filename().string(), footer.front());
    if (session_ && session_->paused()) footer.front() = "PAUSED,  " + footer.front();
    if (!doubt_.empty()) footer.insert(footer.begin(), doubt_);
    window_->show(*shown_, footer);
    const Clock::time_point end = Clock::now();
    next_draw_ = end + (end - start);
  }

  /** The one whose turn it is, if there is one. */
  void drawScreenshots() {
    if (auto result = to_draw_.take({}))
      drawScreenshot(*result->frame, fs::path(options_.screenshots) / (result->frame->image.name + ".png"));
  }

  void drawScreenshot(const LiveResult& result, const fs::path& path) {
    if (!screenshot_) screenshot_ = std::make_unique<LiveScreenshot>(map_);
    requireReplaceable(path);
    writePng(path, screenshot_->draw(result));
    ++screenshots_;
  }

  void obey(LiveCommand command) {
    switch (command) {
    case LiveCommand::screenshot:
      if (shown_) {
        const fs::path path = fs::path(options_.screenshots) / ("live_" + shown_->image.name + ".png");
        drawScreenshot(*shown_, path);
        note("screenshot " + path.string());
      }
      break;
    case LiveCommand::record:
      if (recorder_)
        stopRecording();
      else if (source_->device())
        startRecording(unused(options_.recording.empty() ? "live.oni" : options_.recording));
      break;
    case LiveCommand::pause:
      session_->setPaused(!session_->paused());
      break;
    case LiveCommand::relocalize:
      session_->relocalize();
      break;
    case LiveCommand::quit:
      quit_ = true;
      break;
    }
  }

  void startRecording(const fs::path& file) {
    if (!source_->device())
      throw std::runtime_error(source_->name() + ": only devices of OpenNI2 can be recorded, not files");
    recorder_ = std::make_unique<OniRecorder>(source_->device()->uri(), file);
    recording_ = file;
  }

  void stopRecording() {
    if (!recorder_) return;
    const std::unique_ptr<OniRecorder> recorder = std::move(recorder_);
    const std::size_t frames = recorder->stop();
    note(counted(frames, "frame") + " recorded" + (frames ? " to " + recording_.string() : ""));
  }

  LiveRunOptions options_;
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
  std::unique_ptr<LiveFindings> findings_;  // null where a recording is repeated, whose frames are too
  std::set<std::string> found_;             // ids
  std::string doubt_;                       // the latest, in the window; may be empty
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

}  // namespace

void runLive(const LiveRunOptions& options, const Console& console) {
  LiveRun run(options, console);
  try {
    run.run();
  } catch (...) {
    console.print(run.summary() + "\n");
    throw;
  }
  console.print(run.summary() + "\n");
}

}  // namespace facetloc
