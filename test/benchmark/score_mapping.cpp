// SPDX-License-Identifier: BSD-3-Clause
//
// How well trajectories are found from depth images alone, against the true ones.
//
//   facetloc_simulate office -o office1 --seed 1 --width 320 --runs map; ...
//   score_mapping [-o DIR] [--GROUP.PARAMETER VALUE] RECORDING...
//
// Each RECORDING is a depth sequence with groundtruth.txt, such as office1/map. The yardstick is generalized
// ICP from image to image. With -o, DIR/NAME.txt are the trajectories, for facetloc_evaluate.
#include "base/app.h"
#include "evaluation/trajectory_errors.h"
#include "gicp_odometry.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/mapping/trajectory_estimation.h>
#include <facetloc/segmentation/view_builder.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using namespace facetloc;
using benchmarks::GicpOdometry;
using benchmarks::GicpOdometryParams;

constexpr double kPoseTolerance = 0.02;  // [s]
constexpr double kMillimetres = 1000, kPercent = 100;

/** A trajectory that was found, and at what expense. */
struct Found {
  std::vector<StampedPose> poses;
  int breaks = 0;
  double ms_per_image = 0;
};

Found byGicp(const DepthSequence& sequence, const GicpOdometryParams& params) {
  Found found;
  GicpOdometry odometry(params);
  const auto start = std::chrono::steady_clock::now();
  for (std::size_t i = 0; i < sequence.frames().size(); ++i)
    found.poses.push_back({sequence.frames()[i].stamp, odometry.add(sequence.load(i, kWorkingWidth))});
  const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;
  found.ms_per_image = time.count() / static_cast<double>(std::max<std::size_t>(1, found.poses.size()));
  found.breaks = odometry.breaks();
  return found;
}

Found byPlanes(const DepthSequence& sequence, const MappingParams& params, bool with_mounting, int threads) {
  Camera camera;
  if (sequence.camera()) camera = sequence.camera()->camera;
  if (!with_mounting) camera.mounting.reset();
  ViewBuilder builder(camera);
  TrajectoryEstimation estimation(params);
  estimation.setNumberOfThreads(threads);
  const auto start = std::chrono::steady_clock::now();
  for (std::size_t i = 0; i < sequence.frames().size(); ++i)
    estimation.add(builder.build(sequence.load(i, kWorkingWidth)), sequence.frames()[i].stamp);
  estimation.improve();
  const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;
  const CameraTrajectory trajectory = estimation.trajectory();
  const std::vector<int> parts = trajectory.parts();
  Found found;
  for (const TrajectoryPose& pose : trajectory.images)
    if (trajectory.keyframes[pose.keyframe].part == parts.front())
      found.poses.push_back({pose.stamp, pose.T_w_c});
  found.breaks = static_cast<int>(parts.size()) - 1;
  found.ms_per_image = time.count() / static_cast<double>(std::max<std::size_t>(1, trajectory.images.size()));
  return found;
}

void printHeader() {
  std::printf("%-44s %6s %8s | %9s %8s %9s | %8s %9s | %6s %9s\n", "", "images", "way", "ATE RMSE", "of way",
              "max.", "over 1 m", "", "breaks", "per image");
}

void print(const std::string& name, const Found& found, const TrajectoryErrors& e) {
  double share = 0, turn = 0;
  for (const RelativeErrors& r : e.relative)
    if (r.over == kOverMetre) {
      share = r.translationShare();
      turn = r.rotationPerMetre();
    }
  std::printf("%-44s %6zu %6.1f m | %6.0f mm %6.2f %% %6.0f mm | %6.2f %% %5.2f deg | %6d %6.0f ms\n",
              name.c_str(), found.poses.size(), e.length(), kMillimetres * e.absolute.rmse,
              kPercent * e.share(), kMillimetres * e.absolute.max, kPercent * share, turn, found.breaks,
              found.ms_per_image);
  std::fflush(stdout);
}

/** "office1/map" -> "office1_map", for files. */
std::string fileNameOf(const std::string& recording) {
  const fs::path path = (fs::absolute(recording) / "").lexically_normal().parent_path();
  return path.parent_path().filename().string() + "_" + path.filename().string();
}

class ScoreMappingApp : public App {
public:
  ScoreMappingApp()
      : App("score_mapping", "RECORDING... [options]",
            "Finds the trajectory of each recording from its depth images and compares it with the true "
            "one.") {}

private:
  void addOptions(CommandLine& line) override {
    line.addArguments("RECORDING", recordings_);
    line.addOption("output,o", folder_, "DIR", "Write the trajectories here.");
    line.addSwitch("without-mounting", without_mounting_, "Take every camera for one in the hand.");
    line.addSwitch("without-gicp", without_gicp_, "Leave out the yardstick.");
    line.addParams(mapping_, "mapping");
    line.addParams(gicp_, "gicp", CommandLine::Shown::in_help);
  }

  int execute(const CommandLine&, const Console& console) override {
    if (!folder_.empty()) createFolders(folder_);
    printHeader();
    for (const std::string& name : recordings_) {
      const DepthSequence sequence = DepthSequence::open(name);
      judge(name, "planes", byPlanes(sequence, mapping_, !without_mounting_, threads()), sequence);
      if (!without_gicp_) judge(name, "gicp", byGicp(sequence, gicp_), sequence);
    }
    if (!folder_.empty()) console.out << "trajectories in " << folder_ << "\n";
    return kOk;
  }

  void judge(const std::string& name, const std::string& method, const Found& found,
             const DepthSequence& sequence) const {
    print(name + " " + method, found,
          trajectoryErrors(Trajectory(found.poses), sequence.groundTruth(), kPoseTolerance));
    if (!folder_.empty())
      writeTumTrajectory(fs::path(folder_) / (fileNameOf(name) + "_" + method + ".txt"), found.poses);
  }

  std::vector<std::string> recordings_;
  std::string folder_;
  bool without_mounting_ = false, without_gicp_ = false;
  MappingParams mapping_;
  GicpOdometryParams gicp_;
};

}  // namespace

int main(int argc, char** argv) {
  ScoreMappingApp app;
  return runApp(app, argc, argv);
}
