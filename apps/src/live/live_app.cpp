// SPDX-License-Identifier: BSD-3-Clause
#include "cli/tools.h"
#include "inputs/depth_input.h"
#include "inputs/localization_options.h"
#include "live/live_extension.h"
#include "live/live_run.h"
#include "live/live_window.h"
#include "outputs/localization_report.h"
#include "outputs/map_completion.h"
#include "outputs/output_folder.h"
#include "outputs/pose_stream.h"
#include "outputs/provenance.h"

#include <facetloc/features/camera_presets.h>
#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>
#include <facetloc/io/map_database.h>

#include <filesystem>
#include <fmt/format.h>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

/** OpenNI2 changes the working directory for a moment while it opens a device. */
void makeAbsolute(std::string& path) {
  if (!path.empty()) path = fs::absolute(path).lexically_normal().string();
}

/** facetloc_live: segmentation of live depth images, localization in a map, or a map made of them. */
class LiveApp : public App {
public:
  LiveApp()
      : App("facetloc_live", "[--device DEVICE] [--map | --extend | --build MAP.flmap] [options]",
            "Segments live depth images into planes. With --map, finds the camera in a map and follows it; "
            "with --build, makes a map while the camera moves. DEVICE is a camera of OpenNI2 (#1, or a URI) "
            "or of Linux (/dev/video2), - for frames of a program (ROBOT.md), a .scene file, or a recording: "
            ".oni, .mcap, .db3, .bag, .db, a folder or list of images. Keys and mouse: " +
                keysText() + ".") {}

private:
  void addOptions(CommandLine& line) override {
    LiveRunOptions& run = run_;
    line.addOption("device", run.source.device, "DEVICE",
                   "Source of the depth images; the first camera unless given.");
    line.addOption("map", run.maps, "MAP.flmap",
                   "Localize in this map; given several times, in all of them at once.");
    line.addOption("build", run.build, "MAP.flmap",
                   "Make this map while running. The file is valid at any time, complete at the end.");
    line.addOption("extend", run.extend, "MAP.flmap",
                   "Localize in this map, and update it with the run's images at the end.");
    line.addSwitch("overwrite", overwrite_,
                   "Replace an existing map; write results to a folder with other files.");
    line.addOption(
        "camera", run.source.camera, "FILE|NAME",
        fmt::format("Camera: a camera.ini, a map made with it, or a preset: {}. By the recording or "
                    "device unless given.",
                    cameraPresetNames()));
    line.addSwitch("headless", run.headless, "Run without a window.");
    line.addOption("results", run.results, "DIR",
                   "Write poses, states and times to this folder while running.");
    addStreamOption(line, streams_);
    line.addOption("screenshots", run.screenshots, "DIR",
                   "Write screenshots to this folder; without a display, Xvfb must be installed.");
    line.addOption("record", run.recording, "FILE.oni", "Record the device's depth images.");
    line.addOption("odometry", run.odometry, "FILE",
                   "Read wheel odometry and initial poses, as lines of JSON (ROBOT.md); - = standard input.");
    addMapCovers(line, map_covers_, run.session.localization.probability);
    addStartOption(line, run.near);
    line.addOption("remember", run.remember, "FILE",
                   "Keep the last sure pose in this file, and start from it next time.");
    line.addSwitch("wait", run.wait, "Wait for a device that is missing, was unplugged, or sends nothing.");
    line.addSwitch("every-frame", run.source.every_frame,
                   "Process every frame of a recording, at the speed of processing.");
    addMinProbability(line, min_probability_);
    input_.addOptions(line);
    line.rareFromHere();
    line.addOption("max-frames", run.session.max_frames, "N", "Stop after N processed frames; 0 = never.");
    line.addOption("duration", run.duration, "S", "Stop after this time [s]; 0 = never.");
    line.addOption("every", run.every, "N", "Write a screenshot of every N-th processed frame.");
    line.addSwitch("repeat", run.source.repeat, "Play recordings in a loop.");
    line.addOption("topic", run.source.topic, "NAME",
                   "Topic of the depth images, if messages of several were recorded.");
    line.addOption("speed", run.source.speed, "X", "Playback speed factor; 0 = as fast as possible.");
    line.addParams(run.session.localizer, "localizer");
    line.addParams(run.session.odometry_error, "odometry_error");
    addLocalizationOptions(line, run.session.localization);
    line.addParams(run.mapping, "mapping");
    line.addParams(run.places, "map");
    line.addExample("", "the first camera, in a window");
    line.addExample("--device office.scene --map office.flmap", "a simulated camera in a map");
  }

  void checkOptions() const {
    if (!run_.maps.empty() + !run_.build.empty() + !run_.extend.empty() > 1)
      throw UsageError("map, extend and build exclude each other");
    const bool has_map = !run_.maps.empty() || !run_.extend.empty();
    if (streams_ && !has_map && run_.build.empty())
      throw UsageError("stream belongs to --map, --extend or --build: without a map there are no poses");
    if (!run_.odometry.empty() && !has_map && run_.build.empty())
      throw UsageError("odometry belongs to --map, --extend or --build");
    if (!run_.near.empty() && !has_map) throw UsageError("near belongs to --map or --extend");
    if (!run_.remember.empty() && !has_map) throw UsageError("remember belongs to --map or --extend");
    startPose(run_.near, {});
    if (overwrite_ && run_.build.empty() && run_.results.empty())
      throw UsageError("overwrite belongs to --build or --results");
    const std::string& device = run_.source.device;
    if (run_.source.every_frame && (device.empty() || device.front() == '#'))
      throw UsageError("every-frame belongs to a recording: --device FILE");
    if (run_.every < 1) throw UsageError("every must be positive");
    if (run_.session.max_frames < 0) throw UsageError("max-frames must not be negative");
    if (!(run_.duration >= 0)) throw UsageError("duration must not be negative");
    if (!(run_.source.speed >= 0)) throw UsageError("speed must not be negative");
  }

  int execute(const CommandLine& line, const Console& console) override {
    checkOptions();
    LiveRunOptions options = run_;
    if (streams_) options.stream = &console.out;
    playOrMap(options, line, streams_ ? besideStream(console) : console);
    return kOk;
  }

  void playOrMap(LiveRunOptions options, const CommandLine& line, const Console& console) const {
    for (std::string& map : options.maps) makeAbsolute(map);
    for (std::string* path : {&options.build, &options.extend, &options.remember, &options.results,
                              &options.screenshots, &options.recording})
      makeAbsolute(*path);
    if (options.odometry != "-") makeAbsolute(options.odometry);
    if (options.odometry != "-" && !options.odometry.empty() && !fs::exists(options.odometry))
      throw IoError(options.odometry, "does not exist");
    if (options.source.device == "-" && options.odometry == "-")
      options.odometry.clear();  // one pipe for both
    for (std::string* path : {&options.source.device, &options.source.camera})
      if (fs::exists(*path)) makeAbsolute(*path);
    for (const std::string* folder : {&options.results, &options.screenshots})
      if (!folder->empty()) createFolders(*folder);
    const fs::path played = options.source.device, depth = played / "depth";
    for (const std::string* folder : {&options.results, &options.screenshots})
      if (!folder->empty() && fs::is_directory(played))
        requireOtherFolder(*folder, fs::is_directory(depth) ? depth : played);
    if (!options.results.empty()) {
      Provenance::requireNotReplaced(line.paramsFile(), options.results);
      claimFolder(options.results, marksOfResults(), overwrite_, &console);
    }
    if (fs::exists(options.recording)) throw IoError(options.recording, "exists already");

    if (!options.extend.empty()) return playAndExtend(options, line, console);
    if (options.build.empty()) return play(options, line, console);
    const OutputLock lock = OutputLock::ofFile(options.build);
    const std::string map = options.build;
    const auto build = [&](const fs::path& path) {
      options.build = path.string();
      play(options, line, console);
      if (!isThere(path)) throw IoError(map, "is not written: no frame came");
      completeMap(path, threads(), console, true);
    };
    if (overwrite_ && isThere(map)) {
      openMap(map);  // throws for a file that is no map, which is left alone
      replaceMap(map, build);
    } else {
      if (isThere(map)) throw IoError(map, "exists already; --overwrite replaces it");
      build(map);
    }
    console.print("map in " + map + "\n");
  }

  /** Images of a run that was killed are taken up first. */
  void playAndExtend(const LiveRunOptions& options, const CommandLine& line, const Console& console) const {
    MapUpdateParams params;
    params.places = options.places;
    params.trajectory = options.mapping;
    params.view = input_.view;
    LiveRunOptions in_map = options;
    in_map.maps = {options.extend};
    const OutputLock lock = OutputLock::ofFile(options.extend);
    takeUpSession(options.extend, params, threads(), console);
    play(in_map, line, console);
    takeUpSession(options.extend, params, threads(), console);
  }

  void play(LiveRunOptions options, const CommandLine& line, const Console& console) const {
    options.camera = [&](const std::optional<CameraFile>& file) { return input_.camera(file, line); };
    options.session.view = input_.view;
    options.session.width = input_.width;
    options.session.threads = threads();
    if (line.given("min-probability")) options.min_probability = min_probability_;
    runLive(options, console);
  }

  LiveRunOptions run_;
  DepthInput input_;
  std::string map_covers_;
  double min_probability_ = kMinProbability;
  bool overwrite_ = false, streams_ = false;
};

}  // namespace

std::unique_ptr<App> liveApp() { return std::make_unique<LiveApp>(); }

}  // namespace facetloc
