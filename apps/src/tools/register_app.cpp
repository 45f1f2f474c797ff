// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "cli/progress.h"
#include "cli/text.h"
#include "cli/tools.h"
#include "inputs/depth_input.h"
#include "inputs/localization_options.h"
#include "outputs/localization_report.h"
#include "outputs/output_folder.h"

#include <facetloc/features/answer_state.h>
#include <facetloc/io/cloud_file.h>
#include <facetloc/io/segment_file.h>
#include <facetloc/localization/localization_params.h>
#include <facetloc/registration/pair_registration.h>

#include <chrono>
#include <filesystem>
#include <fmt/core.h>
#include <system_error>

namespace facetloc {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

DepthSequence openImage(const std::string& path, const RecordingHints& hints, const Console& console) {
  DepthSequence sequence = openSequence(path, hints, console);
  if (sequence.frames().size() != 1) throw UsageError(path + " is not one image");
  return sequence;
}

/** The target as results name it: its name and its camera, whose frame is the world. */
Map targetMap(const FrameFile& frame, const View& view) {
  Map map;
  if (view.camera) map.camera = *view.camera;
  map.models.emplace_back(frame.name, frame.stamp, Eigen::Isometry3d::Identity());
  return map;
}

/** facetloc_register: the pose of one depth image relative to another. */
class RegisterApp : public App {
public:
  RegisterApp()
      : App("facetloc_register", "SOURCE TARGET [-o DIR] [options]",
            "Registers two depth images by their planar segments. Prints the ranked poses of the SOURCE "
            "camera in the TARGET camera (x right, y down, z forward). SOURCE and TARGET are 16-bit PNG "
            "files with a camera.ini beside them or in the folder above, organized PCD files, or files "
            "*.segments.pcd of facetloc_segment. The prior is the identity, with the spread of "
            "--prior.rotation_std_deg and --prior.translation_std. If both camera.ini files have the same "
            "mounting, the prior is a robot's on a floor.") {}

private:
  void addOptions(CommandLine& line) override {
    line.addArgument("SOURCE", source_);
    line.addArgument("TARGET", target_);
    line.addOption("output,o", folder_, "DIR",
                   "Also write a results folder: hypotheses.csv, poses_tum.txt, ...");
    addOverwrite(line, overwrite_);
    line.addOption("aligned", aligned_, "FILE.pcd",
                   "Also write the points or segments of the SOURCE in the TARGET camera's axes.");
    line.addOption("max-hypotheses", max_hypotheses_, "K", "Maximum number of poses.");
    addMinProbability(line, min_probability_);
    line.addPresets();
    input_.addAllOptions(line);
    addLocalizationOptions(line, localization_);
    line.addExample("a.pcd b.pcd", "the pose of the camera of a in b");
    line.addExample("a.pcd b.pcd --aligned moved.pcd", "a in the frame of b");
  }

  /** The first pose, sure or not, moves it. */
  void writeAligned(const DepthSequence& source, const Eigen::Isometry3d& T_target_source) const {
    if (!source.ofSegments()) {
      const DepthImage image = source.load(0);
      const fs::path& path = source.frames()[0].path;
      writeCloud(aligned_, image, T_target_source,
                 text::lowerExtension(path) == ".pcd" ? readColours(path, image)
                                                      : std::vector<PointColour>());
      return;
    }
    std::vector<Segment> moved = source.segments(0);
    for (Segment& segment : moved) segment = transformed(segment, T_target_source);
    writeSegments(aligned_, moved);
  }

  int execute(const CommandLine& line, const Console& console) override {
    if (max_hypotheses_ < 1) throw UsageError("max-hypotheses must be positive");
    if (!aligned_.empty() && text::lowerExtension(aligned_) != ".pcd")
      throw UsageError("aligned points are a PCD file: --aligned " + aligned_);
    for (const std::string& input : {source_, target_})
      if (std::error_code ignored; fs::equivalent(input, aligned_, ignored))
        throw UsageError("--aligned would replace " + input);
    if (!folder_.empty()) claimFolder(folder_, marksOfResults(), overwrite_, &console);
    input_.recording.segments = true;
    const DepthSequence source = openImage(source_, input_.recording, console),
                        target = openImage(target_, input_.recording, console);
    const Camera source_camera = input_.camera(source.camera(), line),
                 target_camera = input_.camera(target.camera(), line);
    ViewBuilder target_builder(target_camera, input_.view), builder(source_camera, input_.view);
    const View scene = viewOf(source, 0, input_.width, builder);
    const PairRegistration registration(viewOf(target, 0, input_.width, target_builder), localization_);
    const Map map = targetMap(target.frames()[0], registration.target());
    noteDifference(source_camera, map, console);

    const Clock::time_point start = Clock::now();
    Localization answer = registration.align(scene);
    const double milliseconds = millisecondsSince(start);
    answer.decide(min_probability_);

    const FrameFile& frame = source.frames()[0];
    FrameResult result;
    result.stamp = frame.stamp;
    result.rows = resultRows(frame.name, answer, map, max_hypotheses_);
    result.timing = {frame.name, builder.segmentMilliseconds(), builder.featuresMilliseconds(), milliseconds,
                     1};
    const bool has_pose = !answer.hypotheses.empty();
    if (has_pose) printPoses(console.out, result.rows, "target");
    console.out << toString(answer.state);
    if (answer.state == AnswerState::unknown)
      console.out << ": " << (has_pose ? "the views more likely show different places" : answer.reason);
    if (answer.state == AnswerState::doubtful) console.out << ": no pose is likely enough to act on it";
    console.out << "\n";
    console.out << fmt::format(
        "{}, {}, registered in {:.1f} ms", counted(scene.segments.size(), "source segment"),
        counted(registration.target().segments.size(), "target segment"), milliseconds);
    if (!aligned_.empty() && !has_pose) {
      console.note(fmt::format("no pose was found to move the source by: {} is not written", aligned_));
    } else if (!aligned_.empty()) {
      writeAligned(source, answer.hypotheses.front().T_m_c.T);
      console.out << "; aligned source in " << aligned_;
    }
    if (!folder_.empty()) {
      writeResults(folder_, {result}, toIni(input_, source_camera) + localizationIni(localization_));
      console.out << "; results in " << folder_;
    }
    console.out << "\n";
    return kOk;
  }

  std::string source_, target_, folder_, aligned_;
  double min_probability_ = kMinProbability;
  int max_hypotheses_ = 10;
  bool overwrite_ = false;
  DepthInput input_;
  GlobalLocalizationParams localization_;
};

}  // namespace

std::unique_ptr<App> registerApp() { return std::make_unique<RegisterApp>(); }

}  // namespace facetloc
