// SPDX-License-Identifier: BSD-3-Clause
#include "tools/register_app.h"

#include "tools/localization_report.h"
#include "tools/milliseconds.h"
#include "tools/text.h"

#include <facetloc/io/text.h>

#include <chrono>

namespace facetloc {
namespace {

using Clock = std::chrono::steady_clock;

DepthSequence openImage(const std::string& path, const RecordingHints& hints, const Console& console) {
  DepthSequence sequence = openSequence(path, hints, console);
  if (sequence.frames().size() != 1) throw UsageError(path + " is not one image");
  return sequence;
}

/** The target, with its name. */
Map mapOfTarget(const FrameFile& frame, View view) {
  Map map = mapOf(std::move(view));
  map.models[0].name = frame.name;
  map.models[0].stamp = frame.stamp;
  return map;
}

}  // namespace

RegisterApp::RegisterApp()
    : App("facetloc_register", "SOURCE TARGET [-o DIR] [options]",
          "Registers two depth images by their planar segments and prints the ranked poses of the SOURCE "
          "camera in the "
          "TARGET camera (x right, y down, z forward). SOURCE and TARGET are 16-bit PNG files with a "
          "camera.ini beside "
          "them or in the folder above, or organized PCD files. The prior is the identity, with the spread "
          "of "
          "--prior.rotation_std_deg and --prior.translation_std; it is a robot's on a floor if both "
          "camera.ini "
          "files tell "
          "the same mounting of the camera.") {}

void RegisterApp::addOptions(CommandLine& line) {
  line.addArgument("SOURCE", source_);
  line.addArgument("TARGET", target_);
  line.addOption("output,o", folder_, "DIR",
                 "Also write a results folder: hypotheses.csv, poses_tum.txt, ...");
  line.addOption("max-hypotheses", max_hypotheses_, "K", "List so many poses at most.");
  addMinProbability(line, min_probability_);
  line.addPresets();
  addRecordingOptions(line, input_.recording);
  input_.addOptions(line);
  line.addParams(localization_);
}

int RegisterApp::execute(const CommandLine& line, const Console& console) {
  if (max_hypotheses_ < 1) throw UsageError("max-hypotheses must be positive");
  const DepthSequence source = openImage(source_, input_.recording, console),
                      target = openImage(target_, input_.recording, console);
  const Camera source_camera = input_.camera(source.camera(), line),
               target_camera = input_.camera(target.camera(), line);
  const DepthImage source_image = source.load(0, input_.width), target_image = target.load(0, input_.width);

  const auto map = std::make_shared<const Map>(
      mapOfTarget(target.frames()[0], ViewBuilder(target_camera, input_.view).build(target_image)));
  noteDifference(source_camera, *map, console);
  GlobalLocalization localization(map, localization_);
  localization.setNumberOfThreads(threads());

  ViewBuilder builder(source_camera, input_.view);
  const View scene = builder.build(source_image);
  const Clock::time_point start = Clock::now();
  const Localization answer = localization.localize(scene);
  const double milliseconds = millisecondsSince(start);

  const FrameFile& frame = source.frames()[0];
  FrameResult result;
  result.stamp = frame.stamp;
  result.rows = resultRows(frame.name, answer, *map, max_hypotheses_, min_probability_);
  result.timing = {frame.name, builder.segmentMilliseconds(), builder.featuresMilliseconds(), milliseconds,
                   1};
  const AnswerState state = answer.state(min_probability_);
  if (state != AnswerState::unknown) printPoses(console.out, result.rows);
  console.out << toString(state);
  if (state == AnswerState::unknown) console.out << ": " << answer.reason;
  if (state == AnswerState::doubtful) console.out << ": no pose is likely enough to act on it";
  console.out << "\n";
  console.out << counted(scene.segments.size(), "source segment") << ", "
              << counted(map->models[0].view.segments.size(), "target segment") << ", registered in "
              << text::decimals(milliseconds, 1) << " ms";
  if (!folder_.empty()) {
    writeResults(folder_, {result}, toIni(input_, source_camera) + toIni(localization_));
    console.out << "; results in " << folder_;
  }
  console.out << "\n";
  return kOk;
}

}  // namespace facetloc
