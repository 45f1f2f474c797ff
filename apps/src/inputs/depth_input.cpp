// SPDX-License-Identifier: BSD-3-Clause
#include "inputs/depth_input.h"

#include "base/text.h"
#include "cli/text.h"
#include "inputs/recording_run.h"
#include "outputs/localization_report.h"
#include "outputs/provenance.h"

#include <facetloc/features/camera_presets.h>
#include <facetloc/features/map_parts.h>
#include <facetloc/io/depth_values.h>
#include <facetloc/io/error.h>
#include <facetloc/io/map_database.h>

#include <cmath>
#include <fmt/core.h>
#include <memory>
#include <stdexcept>

namespace facetloc {

void DepthInput::addOptions(CommandLine& line) {
  line.addOption("width", width, "N", "Minimum width to which images are subsampled [px]; 0 = full size.");
  line.addCheck([this] {
    constexpr int kLeastWidth = 40;  // [px] below, an image shows no segments
    if (width != 0 && width < kLeastWidth)
      throw UsageError(fmt::format("width = {} is neither 0 nor at least {}", width, kLeastWidth));
  });
  line.addParams(noise, "noise");
  line.addParams(view);
}

void addTimeOffset(CommandLine& line, double& seconds) {
  line.addOption("time-offset", seconds, "S", "Offset from image timestamps to pose timestamps [s].");
  line.addCheck([&seconds] {
    if (!std::isfinite(seconds)) throw UsageError("time-offset must be a number");
  });
}

void addRecordingOptions(CommandLine& line, RecordingHints& recording) {
  line.addOption(
      "camera", recording.camera, "FILE|NAME",
      fmt::format("Camera: a camera.ini, a map made with it, or a preset (range and typical intrinsics): {}.",
                  cameraPresetNames()));
  line.addOption("topic", recording.topic, "NAME",
                 "Topic of the depth images, if messages of several were recorded.");
  line.addOption("depth-scale", recording.depth_scale, "N", "Image values per metre; 0 = by camera.ini.");
  addTimeOffset(line, recording.time_offset);
  line.addOption("poses-are", recording.poses_are, "LIST",
                 "Convention of the poses: auto, or a list of wxyz, inverse, base and opengl.");
  line.addCheck([&recording] {
    try {
      PoseReading::of(recording.poses_are);
    } catch (const std::invalid_argument& e) {
      throw UsageError(std::string("poses-are: ") + e.what());
    }
    if (!(recording.depth_scale >= 0 && std::isfinite(recording.depth_scale)))
      throw UsageError("depth-scale must not be negative");
  });
}

Camera DepthInput::camera(const std::optional<CameraFile>& file, const CommandLine& line) const {
  Camera camera;
  if (file) camera = file->camera;
  line.takeGiven(camera.noise, noise, "noise");
  return camera;
}

DepthSequence openSequence(const std::string& path, const RecordingHints& hints, const Console& console) {
  DepthSequence sequence = DepthSequence::open(path, hints);
  for (const Finding& finding : readingFindings(sequence)) console.find(finding);
  if (sequence.ofSegments())
    console.find({"reading.segments", Severity::note,
                  path + " holds segments without depth: only planes are compared, and more of the sure "
                         "answers are wrong than with images",
                  ""});
  return sequence;
}

View viewOf(const DepthSequence& sequence, std::size_t index, int working_width, ViewBuilder& builder,
            const std::optional<Gravity>& gravity) {
  if (!sequence.ofSegments()) return builder.build(sequence.load(index, working_width), gravity);
  View view = viewOfSegments(sequence.segments(index), builder.camera().noise);
  view.camera = std::make_shared<const Camera>(builder.camera());
  view.intrinsics = view.camera->intrinsics.valid() ? view.camera->intrinsics : kinectIntrinsics();
  view.intrinsics = view.intrinsics.subsampled(subsamplingStep(view.intrinsics, working_width));
  view.gravity = gravity;
  return view;
}

Map noteUnfinished(Map map, const std::string& path, const Console& console) {
  const auto state = map.meta.find(kStateKey);
  if (state != map.meta.end() && state->second == kUnderWay)
    console.find({"map.unfinished", Severity::doubt,
                  fmt::format("{}: its build has not ended, or was interrupted: it has {} so far", path,
                              counted(map.models.size(), "local model")),
                  "facetloc_map build --resume goes on"});
  return map;
}

std::shared_ptr<const Map> openMaps(const std::vector<std::string>& paths, const Console& console) {
  std::vector<JoinedMap> maps;
  for (const std::string& path : paths)
    maps.push_back({std::filesystem::path(path).stem().string(),
                    std::make_shared<const Map>(noteUnfinished(openMap(path), path, console))});
  if (maps.size() == 1) return maps.front().map;
  try {
    return std::make_shared<const Map>(joinMaps(std::move(maps)));
  } catch (const std::invalid_argument& error) {
    throw IoError(paths.back(), error.what());
  }
}

void noteDifference(const Camera& of_images, const Map& map, const Console& console) {
  for (const Finding& finding : differenceFindings(of_images, map)) console.find(finding);
}

void noteNoise(std::vector<double> found, const SensorNoise& specified, const Console& console) {
  constexpr double kMuch = 1.3;  // times the specification; a Kinect has up to 1.2 times
  const double median = medianOfKnown(std::move(found));
  const double expected = specified.ofInverseDepth(DepthNoise::kUsualDepth);
  if (!(median > kMuch * expected)) return;
  const std::string numbers = fmt::format("{:.2g}, not {:.2g}", median, expected);
  console.find({"camera.noise",
                Severity::doubt,
                fmt::format("the images are noisier than their camera's specification: {} {}; fewer answers "
                            "are sure",
                            specified.isConstantInInverseDepth()
                                ? std::string("inverse_depth_std is about")
                                : fmt::format("at {:.0f} m, the noise of inverse depth [1/m] is about",
                                              DepthNoise::kUsualDepth),
                            numbers),
                "",
                {{"inverse_depth_std", median}, {"specified", expected}}});
}

void printNoise(std::ostream& out, const std::vector<NoiseBin>& bins) {
  TextTable table(
      {"depth [m]", "flat tiles", "std of depth [mm]", "std of 1/z [1/m]", "correlated over [px]"});
  for (const NoiseBin& bin : bins)
    table.add({fmt::format("{:.1f} to {:.1f}", bin.nearest, bin.farthest), std::to_string(bin.samples),
               text::significant(1e3 * bin.depthStd(), 3),
               text::significant(bin.typical.inverse_depth_std, 3),
               text::decimals(bin.typical.correlation_px, 1)});
  out << table;

  const DepthNoise noise = fittedNoise(bins);
  std::string fit = fmt::format("inverse_depth_std = {:.3g}", noise.inverse_depth_std);
  if (noise.depth_std > 0) fit += fmt::format(", depth_std = {:.3g}", noise.depth_std);
  if (noise.depth_std_slope > 0) fit += fmt::format(", depth_std_slope = {:.3g}", noise.depth_std_slope);
  const double percent = 100 * std::expm1(misfit(noise, bins));  // a root mean square of logarithms
  out << fmt::format("Correlated over {:.1f} px. {} is within {:.0f} % of the table.\n",
                     correlationLength(bins), fit, percent);
}

void addPoseTolerance(CommandLine& line, double& seconds) {
  line.addOption("pose-tolerance", seconds, "S", "Maximum time between an image and its pose [s].");
  line.addCheck([&seconds] {
    if (!(seconds >= 0)) throw UsageError("pose-tolerance must not be negative");
  });
}

Trajectory givenPoses(const DepthSequence& sequence, const std::string& file, const Console& console) {
  if (file.empty()) return sequence.groundTruth();
  std::string remark;
  Trajectory poses = sequence.readPoses(file, &remark);
  if (!remark.empty()) console.find({"reading.poses", Severity::note, remark, ""});
  return poses;
}

std::string toIni(const DepthInput& input, const Camera& camera) {
  return fmt::format("width = {}\n{}{}", input.width, toIni(camera.noise, "noise"), toIni(input.view));
}

}  // namespace facetloc
