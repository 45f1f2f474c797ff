// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "batch/batch.h"
#include "cli/text.h"
#include "cli/tools.h"
#include "inputs/depth_input.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/error.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <fmt/core.h>
#include <string>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

constexpr double kFineScale = 5000;      // scale of images converted from clouds: TUM's, 0.2 mm
constexpr double kLargestValue = 65534;  // largest value of a PNG; 65535 is not measured

/** facetloc_convert: a recording of any layout -> a folder of PNGs with everything beside them. */
class ConvertApp : public App {
public:
  ConvertApp()
      : App("facetloc_convert", "RECORDING -o DIR [options]",
            "Converts a recording of any layout to a folder that every tool reads: depth/<stamp>.png, "
            "camera.ini, and, where available, groundtruth.txt, odometry.txt and gravity.txt. Images are "
            "named by their timestamps [s].") {}

private:
  void addOptions(CommandLine& line) override {
    line.addArgument("RECORDING", input_);
    line.addOption("output,o", folder_, "DIR", "Output folder, new or empty.");
    line.addOption("every", every_, "N", "Convert every N-th image only.");
    line.addOption("scale", scale_, "N",
                   "PNG values per metre; 0 = as in the recording, or 5000 for clouds.");
    addRecordingOptions(line, recording_);
    line.addCheck([this] {
      if (every_ < 1) throw UsageError("every must be positive");
      if (!(scale_ >= 0 && std::isfinite(scale_))) throw UsageError("scale must not be negative");
    });
    line.addExample("walk.bag -o walk", "a ROS bag as a folder of PNG images");
    line.addExample("run.oni -o run", "a recording of OpenNI");
  }

  /** Clouds without a camera have the intrinsics that the first of them shows. */
  CameraFile outputCamera(const DepthSequence& sequence) const {
    CameraFile camera = sequence.camera().value_or(CameraFile());
    if (!camera.camera.intrinsics.valid()) {
      camera.camera.intrinsics = sequence.load(0).camera;
      camera.depth_scale = kFineScale;
    }
    if (text::lowerExtension(sequence.frames().front().path) == ".pcd") camera.depth_scale = kFineScale;
    camera.lens = {}, camera.depth_is = DepthKind::z;  // images that are read are a pinhole camera's
    if (scale_ > 0) camera.depth_scale = scale_;
    camera.y_axis_up = false;  // poses are written for a camera as all others
    return camera;
  }

  int writeImages(const DepthSequence& sequence, const CameraFile& camera, const Console& console) const {
    const std::size_t total = (sequence.frames().size() + every_ - 1) / every_;
    const double farthest = kLargestValue / camera.depth_scale;
    std::atomic<std::size_t> beyond = 0;
    Batch batch(threads(), total, console);
    batch.run([&](std::size_t i) { return sequence.frames()[i * every_].path.string(); },
              [&](std::size_t i, int) {
                const std::size_t index = i * every_;
                const DepthImage image = sequence.load(index);
                beyond += std::count_if(image.depth.begin(), image.depth.end(),
                                        [=](float z) { return std::isfinite(z) && z > farthest; });
                writeDepthPng(fs::path(folder_) / "depth" / (sequence.frames()[index].name + ".png"), image,
                              camera.depth_scale);
              });
    if (beyond > 0)
      console.note(fmt::format(
          "{} farther than {:.1f} m do not fit PNGs and are left out; --scale 1000 would keep up to 65.5 m",
          counted(beyond, "pixel"), farthest));
    const int code = batch.report();
    console.out << counted(total - batch.failures().size(), "image");
    return code;
  }

  void writePoses(const DepthSequence& sequence, const Console& console) const {
    const auto write = [&](const char* name, const Trajectory& poses) {
      writeTumTrajectory(fs::path(folder_) / name, poses.poses());
      console.out << ", " << counted(poses.poses().size(), "pose") << " in " << name;
    };
    if (!sequence.groundTruth().empty()) write("groundtruth.txt", sequence.groundTruth());
    if (!DepthSequence::isOfMessages(input_)) return;
    std::string remark;
    try {
      write("odometry.txt", sequence.readOdometry(input_, &remark));
      console.note(remark);
    } catch (const IoError& e) {
      console.note(e.what());
    }
    const GravityRecord gravity = sequence.gravity(kDegree, &remark);
    console.note(remark);
    if (gravity.empty()) return;
    writeGravity(fs::path(folder_) / "gravity.txt", gravity.samples());
    console.out << ", gravity.txt";
  }

  int execute(const CommandLine&, const Console& console) override {
    if (folder_.empty()) throw UsageError("the folder to write to is missing: -o FOLDER");
    const DepthSequence sequence = openSequence(input_, recording_, console);
    if (fs::exists(folder_) && !(fs::is_directory(folder_) && fs::is_empty(folder_)))
      throw IoError(folder_, "exists already; remove it or use another folder");
    sequence.groundTruth();  // poses that cannot be read end it before the work
    const CameraFile camera = outputCamera(sequence);
    createFolders(fs::path(folder_) / "depth");
    writeCameraFile(fs::path(folder_) / "camera.ini", camera);
    const int code = writeImages(sequence, camera, console);
    writePoses(sequence, console);
    if (!sequence.stamped())
      console.note("the recording has no times: its images keep their names, and poses cannot be matched");
    console.out << "; recording in " << folder_ << "\n";
    return code;
  }

  std::string input_, folder_;
  RecordingHints recording_;
  double scale_ = 0;
  int every_ = 1;
};

}  // namespace

std::unique_ptr<App> convertApp() { return std::make_unique<ConvertApp>(); }

}  // namespace facetloc
