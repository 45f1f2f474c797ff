// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "batch/batch.h"
#include "cli/text.h"
#include "cli/tools.h"
#include "evaluation/frame_truth.h"

#include <facetloc/features/camera_presets.h>
#include <facetloc/io/atomic_file.h>
#include <facetloc/io/camera_file.h>
#include <facetloc/io/cloud_file.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/error.h>
#include <facetloc/io/gravity_record.h>
#include <facetloc/io/occupancy_grid_file.h>
#include <facetloc/io/segment_file.h>
#include <facetloc/io/trajectory.h>
#include <facetloc/simulation/simulated_camera.h>
#include <facetloc/simulation/simulated_drive.h>
#include <facetloc/simulation/simulated_people.h>
#include <facetloc/simulation/simulated_place.h>
#include <facetloc/simulation/simulated_sensors.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <functional>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

constexpr double kDepthScale = 5000;     // [1/m]
constexpr double kBetweenStarts = 1000;  // [s] or a multiple: no two runs have images of the same stamp
constexpr std::uint64_t kSeedOfRounds = kRunSeeds - 1;
constexpr int kMostFrames = 1000000;
constexpr int kMostRounds = 1000;
constexpr int kMostPeople = 100;
constexpr double kSwayInRounds = 4;  // [deg] of the mapping run, so that it never looks the same way twice
constexpr double kMostBent = 1;      // [m]
constexpr const char* kUsualCamera = "kinect";
constexpr const char *kMap = "map", *kQuery = "query", *kDrive = "drive";
constexpr double kWalls = 0.3;    // [m] thickness that belongs to a room
constexpr double kInside = 0.95;  // share of the pixels in a view of nothing but the room
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

std::vector<StampedPose> stamped(const std::vector<double>& stamps,
                                 const std::vector<Eigen::Isometry3d>& poses) {
  std::vector<StampedPose> all;
  for (std::size_t i = 0; i < poses.size(); ++i) all.push_back({stamps[i], poses[i]});
  return all;
}

std::map<int, WorldPlane> planesOf(const SimulatedWorld& scene) {
  std::map<int, WorldPlane> planes;
  for (const Rectangle& r : scene.rectangles)
    planes.emplace(r.plane_id, WorldPlane{r.normal(), r.normal().dot(r.centre)});
  return planes;
}

/** Images of another width with the same field of view. */
Intrinsics scaled(Intrinsics k, int width) {
  const double scale = static_cast<double>(width) / k.width;
  k.height = static_cast<int>(std::lround(k.height * scale));
  k.width = width;
  k.fx *= scale;
  k.fy *= scale;
  k.cx = (k.cx + 0.5) * scale - 0.5;  // pixel centres are at integer coordinates
  k.cy = (k.cy + 0.5) * scale - 0.5;
  return k;
}

/** facetloc_simulate: depth sequences of a simulated place, with the truth. */
class SimulateApp : public App {
public:
  SimulateApp()
      : App("facetloc_simulate", "SCENE -o DIR [options]",
            "Simulates a robot with a Kinect in a place. DIR/map is its first drive; DIR/query a later one "
            "on another line, after some things have moved, partly in new places. Each has camera.ini, "
            "groundtruth.txt and the true plane of each pixel (labels/, planes.csv). query/unmapped.txt "
            "lists images of a room that the first drive never entered. SCENE is one of: office (corridors "
            "and rooms), home (a flat), hall (shelves and columns), corridor (40 m, bare), hotel (12 equal "
            "rooms), boards (flat boards on a bare floor, for --drive.camera_tilt_deg 60), doors (a corridor "
            "with equal doors), passage (60 m of them), box (a cabinet that looks the same from opposite "
            "sides), room (random boxes, nothing moves). With --runs drive also DIR/drive, the later drive "
            "in real time, without labels. With --map_poses.* also map/poses.txt, poses with errors. The "
            "output must not exist yet.") {
    drive_.sway_deg = 10;
  }

private:
  /** A sequence: folder, poses, stamps. */
  struct Run {
    std::string name;
    const SimulatedWorld* scene;
    std::function<std::uint64_t(std::size_t)> noise;  // number of the noise that an image has
    bool labels;
    std::vector<Eigen::Isometry3d> poses;
    std::vector<double> stamps{};
    std::vector<Eigen::Isometry3d> odometry{};  // T_o_b; may be empty
    std::vector<Eigen::Isometry3d> reported{};  // poses with errors; may be empty
    std::vector<StampedGravity> gravity{};      // may be empty
    std::optional<SimulatedPeople> people{};

    std::string frameName(std::size_t i) const { return text::decimals(stamps[i], 6); }
  };

  void addOptions(CommandLine& line) override {
    line.addArgument("SCENE", scene_);
    line.addOption("output,o", folder_, "DIR", "Folder of the sequences.");
    line.addOption("seed", seed_, "N", "Seed of the place, the drives and the noise.");
    line.addOption("width", width_, "N", "Width of the images [px]; the camera's unless given.");
    line.addOption("frames", frames_, "N",
                   "Number of images of each run; 0 = by --map-frames and --query-frames.");
    line.addOption("map-frames", map_frames_, "N", "Number of images of the mapping run.");
    line.addOption("query-frames", query_frames_, "N", "Number of images of the later run.");
    line.addOption("runs", runs_, "RUN,...",
                   "Runs to make, of map, query and drive; map,query unless given.");
    line.addOption("drive", seconds_, "S", "Duration of the continuous drive [s].");
    line.addParams(pace_, "pace");
    line.addOption("rounds", rounds_, "N",
                   "Repeat the route of the mapping run N times, each time on another line.");
    line.addOption("people", people_, "N",
                   "Number of people around the camera: followed, walking past, standing around.");
    line.addOption("map-people", map_people_, "N", "Number of people around the camera of the mapping run.");
    line.addOption("map-step", map_step_, "M", "Distance between images of the mapping run [m].");
    line.addParams(drive_, "drive");
    line.addParams(noise_, "sensor");
    line.addSwitch("odometry", with_odometry_,
                   "Write odometry.txt: poses of the robot's base by its wheels, in the TUM format.");
    line.addParams(odometry_, "odometry");
    line.addOption("gravity", gravity_error_deg_, "DEG",
                   "Write gravity.txt with this error [deg]; -1 = do not write it.");
    line.addOption("camera", preset_, "NAME",
                   fmt::format("Simulated camera, with its errors: {}.", cameraPresetNames()));
    line.addSwitch("shared-errors", shared_errors_,
                   "Add correlated errors: smooth ones, blurred or filled-in edges.");
    line.addOption("surface-error", surface_error_, "M",
                   "Bend the surfaces of the mapping run, rms displacement [m].");
    line.addParams(map_poses_, "map_poses");
    line.addOption("model", model_, "FILE",
                   "Write a PLY mesh of all surfaces that are the same in both runs.");
    line.addOption("grid", grid_, "NAME", "Write an occupancy grid of the walls: NAME.yaml and NAME.pgm.");
    line.addExample("room -o room", "a room, in seconds");
    line.addExample("office -o office --seed 1", "the floor of the demo");
  }

  void setStamps(std::vector<Run>& runs) const {
    double start = 0;
    for (Run& run : runs) {
      run.stamps = drivingTimes(basePoses(run.poses, drive_.mounting()), pace_);
      if (run.name == kDrive)  // sampled by the clock
        for (std::size_t i = 0; i < run.stamps.size(); ++i)
          run.stamps[i] = static_cast<double>(i) / pace_.rate;
      const double length = run.stamps.empty() ? 0 : run.stamps.back();
      for (double& stamp : run.stamps) stamp += start;
      start += kBetweenStarts * (1 + std::floor(length / kBetweenStarts));
    }
  }

  SimulatedPlace makeScenes() const {
    const auto seed = static_cast<std::uint64_t>(seed_);
    if (scene_ != kRoomName) return simulatedPlace(scene_, seed);
    SimulatedPlace room;
    room.mapped = room.later = furnishedRoom(seed);
    return room;
  }

  /** The building itself, for those who have no drive through it. */
  void writeModels(const SimulatedPlace& made, const Console& console) const {
    if (!model_.empty()) {
      writeMesh(model_, meshOf(lastingParts(made)));
      console.out << "mesh in " << model_ << "\n";
    }
    if (grid_.empty()) return;
    if (made.walls.empty()) throw UsageError(fmt::format("the scene '{}' has no walls for a --grid", scene_));
    const fs::path grid = occupancyGridPath(grid_);
    if (grid.has_parent_path()) createFolders(grid.parent_path());
    writeOccupancyGrid(grid, floorPlanOf(made));
    console.out << "floor plan in " << grid.string() << "\n";
  }

  /** The runs through a place that are wanted. */
  std::vector<Run> runsThrough(SimulatedPlace& made) const {
    const auto seed = static_cast<std::uint64_t>(seed_);
    const auto map_frames = static_cast<std::size_t>(frames_ > 0 ? frames_ : map_frames_);
    const auto query_frames = static_cast<std::size_t>(frames_ > 0 ? frames_ : query_frames_);
    const auto drive_frames = static_cast<std::size_t>(std::lround(seconds_ * pace_.rate));
    DriveParams map_drive = drive_;
    map_drive.step = map_step_;
    map_drive.sway_deg = rounds_ > 1 ? kSwayInRounds : 0;

    made.mapped.bending.std = surface_error_;
    made.mapped.bending.seed = seed;
    made.mapping_route = roundsOf(made.mapping_route, rounds_, runSeed(seed, kSeedOfRounds));
    const RouteEnd end = made.one_way ? RouteEnd::stop : RouteEnd::go_round;

    // All runs are driven, whatever is wanted: none depends on the others being made. In a room they meet
    // where the first one starts.
    std::optional<Eigen::Vector2d> start;
    const auto drive = [&](const SimulatedWorld& scene, const Route& route, std::size_t frames,
                           const DriveParams& params, std::uint64_t run,
                           const std::optional<PaceParams>& pace) {
      const std::uint64_t run_seed = runSeed(seed, run);
      if (!route.empty()) return simulateDrive(route, frames, params, run_seed, pace, end);
      std::vector<Eigen::Isometry3d> poses = simulateDrive(scene, frames, params, run_seed, start, pace);
      if (!start) start = poses.front().translation().head<2>();
      return poses;
    };
    const std::size_t further = static_cast<std::size_t>(rounds_ - 1) * map_frames;
    std::vector<Run> runs = {
        {kMap, &made.mapped,
         [=](std::size_t i) { return i < map_frames ? i : i + query_frames + drive_frames; }, true,
         drive(made.mapped, made.mapping_route, map_frames + further, map_drive, 0, {})},
        {kQuery, &made.later, [=](std::size_t i) { return map_frames + i; }, true,
         drive(made.later, made.query_route, query_frames, drive_, 1, {})},
        {kDrive, &made.later, [=](std::size_t i) { return map_frames + query_frames + i; }, false,
         drive(made.later, made.query_route, drive_frames, drive_, 2, pace_)}};
    setStamps(runs);
    if (map_poses_.any()) runs.front().reported = simulateMapPoses(runs.front().poses, map_poses_, seed);
    const std::vector<std::string> wanted = wantedRuns();
    std::vector<Run> driven;
    for (std::size_t i = 0; i < runs.size(); ++i) {
      if (std::find(wanted.begin(), wanted.end(), runs[i].name) == wanted.end()) continue;
      if (const int people = runs[i].name == kMap ? map_people_ : people_; people > 0)
        runs[i].people.emplace(people, runs[i].poses, runs[i].stamps, runSeed(seed, i));
      if (with_odometry_)
        runs[i].odometry = simulateOdometry(basePoses(runs[i].poses, drive_.mounting()), odometry_,
                                            drive_.robot, runSeed(seed, i));
      if (gravity_error_deg_ >= 0) {
        const std::vector<Gravity> found =
            simulateGravity(runs[i].poses, gravity_error_deg_ * kDegree, runSeed(seed, i));
        for (std::size_t k = 0; k < found.size(); ++k)
          runs[i].gravity.push_back({runs[i].stamps[k], found[k]});
      }
      driven.push_back(std::move(runs[i]));
    }
    return driven;
  }

  std::vector<std::string> wantedRuns() const {
    std::vector<std::string> wanted;
    std::istringstream list(runs_);
    for (std::string run; std::getline(list, run, ',');) {
      if (run != kMap && run != kQuery && run != kDrive)
        throw UsageError(fmt::format("unknown run '{}'; there are: map query drive", run));
      wanted.push_back(run);
    }
    return wanted;
  }

  void prepareFolder(const Run& run, const CameraFile& camera) const {
    const fs::path folder = fs::path(folder_) / run.name;
    createFolders(folder / "depth");
    writeCameraFile(folder / "camera.ini", camera);
    if (run.labels) {
      createFolders(folder / "labels");
      writePlanes(folder / "planes.csv", planesOf(*run.scene));
    }
    writeTumTrajectory(folder / "groundtruth.txt", stamped(run.stamps, run.poses));
    if (!run.reported.empty()) writeTumTrajectory(folder / "poses.txt", stamped(run.stamps, run.reported));
    if (!run.gravity.empty()) writeGravity(folder / "gravity.txt", run.gravity);
    if (!run.odometry.empty()) writeTumTrajectory(folder / "odometry.txt", stamped(run.stamps, run.odometry));
  }

  void writeUnmapped(const Run& query, const std::vector<char>& unmapped) const {
    writeTextAtomically(fs::path(folder_) / query.name / "unmapped.txt", [&](std::ostream& out) {
      out << "# images that show only a room the mapping run never entered\n";
      for (std::size_t i = 0; i < query.poses.size(); ++i)
        if (unmapped[i]) out << query.frameName(i) << "\n";
    });
  }

  void checkOptions() const {
    std::vector<std::string> scenes = simulatedPlaceNames();
    scenes.push_back(kRoomName);
    if (std::find(scenes.begin(), scenes.end(), scene_) == scenes.end())
      throw UsageError(fmt::format("unknown scene '{}'; there are: {}", scene_, fmt::join(scenes, " ")));
    if (folder_.empty() && model_.empty() && grid_.empty())
      throw UsageError("the folder of the sequences is missing: -o DIR (or --model FILE, --grid NAME)");
    if (!preset_.empty() && !findCameraPreset(preset_))
      throw UsageError(fmt::format("unknown camera '{}'; there are: {}", preset_, cameraPresetNames()));
    if (seed_ < 0) throw UsageError("seed must not be negative");
    if (width_ < 40 || width_ > 2048) throw UsageError("width must lie in [40, 2048]");
    if (frames_ < 0 || frames_ > kMostFrames) throw UsageError("frames must lie in [0, 1000000]");
    for (const int frames : {map_frames_, query_frames_})
      if (frames < 1 || frames > kMostFrames)
        throw UsageError("map-frames and query-frames must lie in [1, 1000000]");
    for (const int people : {people_, map_people_})
      if (people < 0 || people > kMostPeople) throw UsageError("people and map-people must lie in [0, 100]");
    if (rounds_ < 1 || rounds_ > kMostRounds) throw UsageError("rounds must lie in [1, 1000]");
    if (!(surface_error_ >= 0 && surface_error_ <= kMostBent))
      throw UsageError("surface-error must lie in [0, 1]");
    if (!(gravity_error_deg_ <= 90)) throw UsageError("gravity must be at most 90");
    if (!(map_step_ >= 0.01 && map_step_ <= 10)) throw UsageError("map-step must lie in [0.01, 10]");
    if (!(seconds_ * pace_.rate >= 0.5 && seconds_ * pace_.rate <= kMostFrames))
      throw UsageError("drive must be as long as one image at least, and no longer than a million");
    for (const std::string& run : wantedRuns())
      if (const fs::path folder = fs::path(folder_) / run; !folder_.empty() && fs::exists(folder))
        throw IoError(folder.string(), "exists already; remove it or use another folder");
  }

  int execute(const CommandLine& line, const Console& console) override {
    if (runs_.empty()) runs_ = line.given("drive") ? "map,query,drive" : "map,query";
    checkOptions();
    SimulatedPlace made = makeScenes();
    writeModels(made, console);
    if (folder_.empty()) return kOk;
    const std::vector<Run> runs = runsThrough(made);
    const CameraPreset& preset = *findCameraPreset(preset_.empty() ? kUsualCamera : preset_);
    const Intrinsics intrinsics =
        scaled(preset.intrinsics(), line.given("width") ? width_ : preset.intrinsics().width);
    SimulatedNoise noise =
        simulatedNoise(preset.name, shared_errors_ ? SharedErrors::as_measured : SharedErrors::left_out);
    line.takeGiven(noise, noise_, "sensor");
    const SimulatedCamera camera(intrinsics, noise, static_cast<std::uint64_t>(seed_));
    CameraFile camera_file{preset.camera(), kDepthScale, preset_};
    camera_file.camera.intrinsics = intrinsics;
    camera_file.camera.mounting = drive_.mounting();
    struct Image {
      const Run* run;
      std::size_t index;
    };
    std::vector<Image> images;
    createFolders(folder_);
    const OutputLock lock = OutputLock::ofFolder(folder_);
    for (const Run& run : runs) {
      prepareFolder(run, camera_file);
      for (std::size_t i = 0; i < run.poses.size(); ++i) images.push_back({&run, i});
    }

    std::vector<char> unmapped(images.size(), 0);  // no bits: threads write beside each other
    Batch batch(threads(), images.size(), console);
    batch.run(
        [&](std::size_t i) {
          return fmt::format("{}/{}", images[i].run->name, images[i].run->frameName(images[i].index));
        },
        [&](std::size_t i, int) {
          const auto& [run, index] = images[i];
          const fs::path folder = fs::path(folder_) / run->name;
          const std::string file = run->frameName(index) + ".png";
          const SimulatedFrame frame =
              camera.render(run->people ? run->people->in(*run->scene, index) : *run->scene,
                            run->poses[index], run->noise(index));
          writeDepthPng(folder / "depth" / file, frame.depth, kDepthScale);
          if (run->labels) writeLabels(folder / "labels" / file, frame.labels);
          if (run->name == kQuery)
            unmapped[index] = showsOnly(made.unmapped_rooms, frame.depth, run->poses[index]);
        });
    const int code = batch.report();
    std::string what;
    for (const Run& run : runs) {
      if (run.name == kQuery) writeUnmapped(run, unmapped);
      what +=
          fmt::format("{}{} of {}", what.empty() ? "" : ", ", run.name, counted(run.poses.size(), "image"));
    }
    console.out << what << " in " << folder_ << "\n";
    return code;
  }

  std::string scene_, folder_;
  std::string model_, grid_;  // files of the building; may be empty
  std::string runs_;
  std::string preset_;  // camera
  int seed_ = 1, width_ = 640, frames_ = 0;
  int map_frames_ = 444;    // the paper's
  int query_frames_ = 348;  // the paper's
  int rounds_ = 1;          // rounds of the mapping run
  int people_ = 0, map_people_ = 0;
  double map_step_ = 0.25;
  double seconds_ = 60;  // duration of the continuous drive
  PaceParams pace_;
  DriveParams drive_;
  SimulatedNoise noise_;
  bool shared_errors_ = false;
  double surface_error_ = 0;  // [m]
  MapPoseErrors map_poses_;
  bool with_odometry_ = false;
  double gravity_error_deg_ = -1;  // negative: no file
  WheelOdometryParams odometry_;
};

}  // namespace

std::unique_ptr<App> simulateApp() { return std::make_unique<SimulateApp>(); }

}  // namespace facetloc
