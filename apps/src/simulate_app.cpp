// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/apps/batch.h>
#include <facetloc/apps/segment_file.h>
#include <facetloc/apps/simulate_app.h>
#include <facetloc/apps/text.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/error.h>

#include <cmath>
#include <filesystem>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

constexpr double kDepthScale = 5000;     // [1/m]
constexpr double kFrameInterval = 0.1;   // [s]
constexpr double kQueryStart = 1000;     // [s] no query has the stamp of a map image
constexpr std::uint64_t kRunSeeds = 64;  // seeds per room, for its runs

}  // namespace

struct SimulateApp::Run {
  fs::path folder;
  double first_stamp;
  std::uint64_t first_frame;  // number of its first frame, which selects the noise
  std::vector<Eigen::Isometry3d> poses;

  double stamp(std::size_t i) const { return first_stamp + kFrameInterval * static_cast<double>(i); }
  std::string fileName(std::size_t i) const { return fixed(stamp(i), 6) + ".png"; }
};

SimulateApp::SimulateApp()
    : App("facetloc_simulate", "SCENE -o DIR [options]",
          "Makes two depth sequences of a simulated place, DIR/map and DIR/query, taken by a robot with a "
          "Kinect-like "
          "camera on two different drives, with camera.ini, groundtruth.txt and the true planes of each "
          "pixel "
          "(labels/, 16-bit PNG). SCENE is 'room': a closed room of random size with random boxes. The same "
          "seed gives "
          "the same files.") {}

void SimulateApp::addOptions(CommandLine& line) {
  line.addArgument("SCENE", scene_);
  line.addOption("output,o", folder_, "DIR", "Folder of the sequences.");
  line.addOption("seed", seed_, "N", "Selects the room, the drives and the noise.");
  line.addOption("width", width_, "N", "Width of the images [px]; 4:3.");
  line.addOption("frames", frames_, "N", "Images per sequence.");
  line.addParams(drive_);
  line.addParams(noise_);
}

Intrinsics scaledKinect(int width) {
  Intrinsics k = kinectIntrinsics();
  const double scale = static_cast<double>(width) / k.width;
  k.height = static_cast<int>(std::lround(k.height * scale));
  k.width = width;
  k.fx *= scale;
  k.fy *= scale;
  k.cx = (k.cx + 0.5) * scale - 0.5;  // pixel centres are at integer coordinates
  k.cy = (k.cy + 0.5) * scale - 0.5;
  return k;
}

void SimulateApp::prepareFolder(const Run& run, const CameraFile& camera) const {
  createFolder((run.folder / "depth").string());
  createFolder((run.folder / "labels").string());
  writeCameraFile(run.folder / "camera.ini", camera);
  std::vector<StampedPose> truth;
  for (std::size_t i = 0; i < run.poses.size(); ++i) truth.push_back({run.stamp(i), run.poses[i]});
  writeTumTrajectory(run.folder / "groundtruth.txt", truth);
}

int SimulateApp::execute(const CommandLine&, const Console& console) {
  if (scene_ != "room") throw UsageError("unknown scene '" + scene_ + "'; there is: room");
  if (folder_.empty()) throw UsageError("the folder of the sequences is missing: -o DIR");
  if (seed_ < 0) throw UsageError("seed must not be negative");
  if (width_ < 40 || width_ > 2048) throw UsageError("width must lie in [40, 2048]");
  if (frames_ < 1 || frames_ > 1000000) throw UsageError("frames must lie in [1, 1000000]");

  const auto seed = static_cast<std::uint64_t>(seed_);
  const auto frames = static_cast<std::size_t>(frames_);
  constexpr int kBoxes = 16;  // furnished: most views then show planes of three directions
  const Scene scene = randomRoom(seed, kBoxes);
  const SimulatedCamera camera(scaledKinect(width_), noise_, seed);  // one camera for both runs
  const CameraFile camera_file{camera.camera(), kDepthScale, drive_.mounting(), {}};
  const auto map_drive = simulateDrive(scene, frames, drive_, kRunSeeds * seed);
  const Eigen::Vector2d start = map_drive.front().translation().head<2>();  // of both, so that they meet
  const auto query_drive = simulateDrive(scene, frames, drive_, kRunSeeds * seed + 1, start);
  const Run runs[] = {{fs::path(folder_) / "map", 0, 0, map_drive},
                      {fs::path(folder_) / "query", kQueryStart, frames, query_drive}};
  for (const Run& run : runs)
    if (fs::exists(run.folder))
      throw IoError(run.folder.string(), "exists already; remove it or use another folder");
  for (const Run& run : runs) prepareFolder(run, camera_file);

  Batch batch(threads(), 2 * frames, console);
  const auto runOf = [&](std::size_t i) -> const Run& { return runs[i / frames]; };
  batch.run([&](std::size_t i) { return (runOf(i).folder / runOf(i).fileName(i % frames)).string(); },
            [&](std::size_t i, int) {
              const Run& run = runOf(i);
              const std::size_t k = i % frames;
              const SimulatedFrame frame = camera.render(scene, run.poses[k], run.first_frame + k);
              writeDepthPng(run.folder / "depth" / run.fileName(k), frame.depth, kDepthScale);
              writeLabels(run.folder / "labels" / run.fileName(k), frame.labels);
            });
  const int code = batch.report();
  console.out << "2 sequences of " << counted(frames, "image") << "; map and query in " << folder_ << "\n";
  return code;
}

}  // namespace facetloc
