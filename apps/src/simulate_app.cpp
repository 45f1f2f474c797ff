// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/apps/batch.h>
#include <facetloc/apps/frame_truth.h>
#include <facetloc/apps/segment_file.h>
#include <facetloc/apps/simulate_app.h>
#include <facetloc/apps/text.h>
#include <facetloc/io/atomic_file.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/error.h>
#include <facetloc/io/trajectory.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

constexpr double kDepthScale = 5000;     // [1/m]
constexpr double kFrameInterval = 0.1;   // [s]
constexpr double kQueryStart = 1000;     // [s] no query has the stamp of a map image
constexpr std::uint64_t kRunSeeds = 64;  // seeds per place, for its runs
constexpr int kMostFrames = 1000000;
constexpr const char *kRoom = "room", *kMap = "map", *kQuery = "query";
constexpr double kWalls = 0.3;    // [m] thickness that belongs to a room
constexpr double kInside = 0.95;  // of the pixels, where a room is all that is seen
constexpr int kGrid = 4;          // [px] between the pixels that are asked

/** Does an image show the inside of one of these rooms and hardly anything else? */
bool showsOnly(const std::vector<Eigen::AlignedBox2d>& rooms, const DepthImage& image,
               const Eigen::Isometry3d& T_w_c) {
  const Eigen::Vector2d walls(kWalls, kWalls);
  for (const Eigen::AlignedBox2d& room : rooms) {
    const Eigen::AlignedBox2d with_walls(room.min() - walls, room.max() + walls);
    if (!with_walls.contains(T_w_c.translation().head<2>())) continue;
    int inside = 0, seen = 0;
    for (int v = 0; v < image.camera.height; v += kGrid)
      for (int u = 0; u < image.camera.width; u += kGrid) {
        const double z = image.at(u, v);
        if (!isMeasured(z)) continue;
        ++seen;
        inside += with_walls.contains((T_w_c * (z * image.camera.ray(u, v))).head<2>());
      }
    if (inside >= kInside * seen) return true;
  }
  return false;
}

std::map<int, WorldPlane> planesOf(const Scene& scene) {
  std::map<int, WorldPlane> planes;
  for (const Rectangle& r : scene.rectangles)
    planes.emplace(r.plane_id, WorldPlane{r.normal(), r.normal().dot(r.centre)});
  return planes;
}

}  // namespace

struct SimulateApp::Run {
  std::string name;
  Scene scene;
  double first_stamp;
  std::uint64_t first_frame;  // number of its first image, which selects the noise
  std::vector<Eigen::Isometry3d> poses;

  double stamp(std::size_t i) const { return first_stamp + kFrameInterval * static_cast<double>(i); }
  std::string frameName(std::size_t i) const { return fixed(stamp(i), 6); }
};

struct SimulateApp::Place {
  Run map, query;
  std::vector<Eigen::AlignedBox2d> unmapped_rooms;
};

SimulateApp::SimulateApp()
    : App("facetloc_simulate", "SCENE -o DIR [options]",
          "Makes two depth sequences of a simulated place, taken by a robot with a Kinect-like camera: "
          "DIR/map and DIR/query, a later drive on another line, after some things have moved, partly "
          "where the first one never was. With camera.ini, groundtruth.txt, the true planes of each pixel "
          "(labels/, 16-bit PNG; planes.csv: their equations) and query/unmapped.txt, the images that "
          "show only a room that the first drive never entered. SCENE is one of: office (a loop of "
          "corridors and some rooms), home (a flat), hall (shelves and columns), room (one closed room "
          "with random boxes, where nothing moves). DIR/map and DIR/query must not exist yet. The same "
          "seed and options give the same files.") {
  drive_.sway_deg = 10;
}

void SimulateApp::addOptions(CommandLine& line) {
  line.addArgument("SCENE", scene_);
  line.addOption("output,o", folder_, "DIR", "Folder of the sequences.");
  line.addOption("seed", seed_, "N", "Selects the place, the drives and the noise.");
  line.addOption("width", width_, "N", "Width of the images [px]; 4:3.");
  line.addOption("frames", frames_, "N", "Images per sequence; 0 = as many as the next two options say.");
  line.addOption("map-frames", map_frames_, "N", "Images of the mapping run.");
  line.addOption("query-frames", query_frames_, "N", "Images of the later run.");
  line.addOption("map-step", map_step_, "M", "Like step, for the mapping run [m]; that one does not sway.");
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

SimulateApp::Place SimulateApp::makePlace() const {
  const auto seed = static_cast<std::uint64_t>(seed_);
  const auto map_frames = static_cast<std::size_t>(frames_ > 0 ? frames_ : map_frames_);
  const auto query_frames = static_cast<std::size_t>(frames_ > 0 ? frames_ : query_frames_);
  DriveParams map_drive = drive_;
  map_drive.step = map_step_;
  map_drive.sway_deg = 0;

  Place place{{kMap, {}, 0, 0, {}}, {kQuery, {}, kQueryStart, map_frames, {}}, {}};
  if (scene_ == kRoom) {
    constexpr int kBoxes = 16;  // furnished: most views then show planes of three directions
    place.map.scene = place.query.scene = randomRoom(seed, kBoxes);
    place.map.poses = simulateDrive(place.map.scene, map_frames, map_drive, kRunSeeds * seed);
    const Eigen::Vector2d start = place.map.poses.front().translation().head<2>();  // so that they meet
    place.query.poses = simulateDrive(place.map.scene, query_frames, drive_, kRunSeeds * seed + 1, start);
    return place;
  }
  SimulatedPlace made = simulatedPlace(scene_, seed);
  place.map.poses = simulateDrive(made.mapping_route, map_frames, map_drive, kRunSeeds * seed);
  place.query.poses = simulateDrive(made.query_route, query_frames, drive_, kRunSeeds * seed + 1);
  place.map.scene = std::move(made.mapped);
  place.query.scene = std::move(made.later);
  place.unmapped_rooms = std::move(made.unmapped_rooms);
  return place;
}

void SimulateApp::prepareFolder(const Run& run, const CameraFile& camera) const {
  const fs::path folder = fs::path(folder_) / run.name;
  createFolder((folder / "depth").string());
  createFolder((folder / "labels").string());
  writeCameraFile(folder / "camera.ini", camera);
  writePlanes(folder / "planes.csv", planesOf(run.scene));
  std::vector<StampedPose> truth;
  for (std::size_t i = 0; i < run.poses.size(); ++i) truth.push_back({run.stamp(i), run.poses[i]});
  writeTumTrajectory(folder / "groundtruth.txt", truth);
}

void SimulateApp::writeUnmapped(const Run& query, const std::vector<char>& unmapped) const {
  writeTextAtomically(fs::path(folder_) / query.name / "unmapped.txt", [&](std::ostream& out) {
    out << "# images that show only a room the mapping run never entered\n";
    for (std::size_t i = 0; i < query.poses.size(); ++i)
      if (unmapped[i]) out << query.frameName(i) << "\n";
  });
}

void SimulateApp::checkOptions() const {
  std::vector<std::string> scenes = simulatedPlaceNames();
  scenes.push_back(kRoom);
  if (std::find(scenes.begin(), scenes.end(), scene_) == scenes.end()) {
    std::string names;
    for (const std::string& name : scenes) names += " " + name;
    throw UsageError("unknown scene '" + scene_ + "'; there are:" + names);
  }
  if (folder_.empty()) throw UsageError("the folder of the sequences is missing: -o DIR");
  if (seed_ < 0) throw UsageError("seed must not be negative");
  if (width_ < 40 || width_ > 2048) throw UsageError("width must lie in [40, 2048]");
  if (frames_ < 0 || frames_ > kMostFrames) throw UsageError("frames must lie in [0, 1000000]");
  for (const int frames : {map_frames_, query_frames_})
    if (frames < 1 || frames > kMostFrames)
      throw UsageError("map-frames and query-frames must lie in [1, 1000000]");
  if (!(map_step_ >= 0.01 && map_step_ <= 10)) throw UsageError("map-step must lie in [0.01, 10]");
  for (const char* run : {kMap, kQuery})
    if (const fs::path folder = fs::path(folder_) / run; fs::exists(folder))
      throw IoError(folder.string(), "exists already; remove it or use another folder");
}

int SimulateApp::execute(const CommandLine&, const Console& console) {
  checkOptions();
  const Place place = makePlace();
  const SimulatedCamera camera(scaledKinect(width_), noise_, static_cast<std::uint64_t>(seed_));
  const CameraFile camera_file{camera.camera(), kDepthScale, drive_.mounting(), {}};
  for (const Run* run : {&place.map, &place.query}) prepareFolder(*run, camera_file);

  const std::size_t map_frames = place.map.poses.size(), frames = map_frames + place.query.poses.size();
  const auto runOf = [&](std::size_t i) -> const Run& { return i < map_frames ? place.map : place.query; };
  const auto inRun = [&](std::size_t i) { return i < map_frames ? i : i - map_frames; };
  std::vector<char> unmapped(frames - map_frames, 0);  // no bits: threads write beside each other
  Batch batch(threads(), frames, console);
  batch.run([&](std::size_t i) { return runOf(i).name + "/" + runOf(i).frameName(inRun(i)); },
            [&](std::size_t i, int) {
              const Run& run = runOf(i);
              const fs::path folder = fs::path(folder_) / run.name;
              const std::string file = run.frameName(inRun(i)) + ".png";
              const SimulatedFrame frame =
                  camera.render(run.scene, run.poses[inRun(i)], run.first_frame + inRun(i));
              writeDepthPng(folder / "depth" / file, frame.depth, kDepthScale);
              writeLabels(folder / "labels" / file, frame.labels);
              if (i >= map_frames)
                unmapped[inRun(i)] = showsOnly(place.unmapped_rooms, frame.depth, run.poses[inRun(i)]);
            });
  writeUnmapped(place.query, unmapped);
  const int code = batch.report();
  console.out << "sequences of " << counted(map_frames, "image") << " and "
              << counted(frames - map_frames, "image") << "; map and query in " << folder_ << "\n";
  return code;
}

}  // namespace facetloc
