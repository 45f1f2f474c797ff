// SPDX-License-Identifier: BSD-3-Clause
#include "batch/batch.h"
#include "batch/map_watch.h"
#include "cli/text.h"
#include "outputs/map_completion.h"
#include "outputs/provenance.h"
#include "tools/map_apps.h"

#include <facetloc/io/depth_values.h>
#include <facetloc/io/error.h>
#include <facetloc/io/output_lock.h>

#include <algorithm>
#include <fmt/core.h>
#include <map>
#include <memory>
#include <utility>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

constexpr const char* kParametersKey = "parameters";
constexpr double kSamePose = 1e-9;  // rounding of a file [m], and of the entries of a rotation

bool samePose(const std::optional<Eigen::Isometry3d>& a, const std::optional<Eigen::Isometry3d>& b) {
  if (!a || !b) return !a && !b;
  return (a->matrix() - b->matrix()).cwiseAbs().maxCoeff() < kSamePose;
}

// An empty file holds nothing that could be lost.
bool isThere(const fs::path& path) {
  return fs::exists(path) && !(fs::is_regular_file(path) && fs::file_size(path) == 0);
}

// Removes the map of a build that came to nothing.
void removeWithoutModels(const fs::path& path) try {
  if (openMap(path).models.empty()) fs::remove(path);
} catch (const std::exception&) {  // the error that ended the build is reported
}

}  // namespace

/** Statistics of local models and their images. */
struct MapBuildApp::Seen {
  std::size_t added = 0, models = 0;
  std::vector<double> noise;  // inverse-depth noise by image [1/m]
  std::size_t without_segments = 0;
};

MapBuildApp::MapBuildApp()
    : App("facetloc_map build", "SEQUENCE -o MAP.flmap [options]",
          "Builds a map from a recording: local models, the planar segments of chosen images, and links "
          "between them. Poses come from the recording, from --poses, or from the images.") {}

void MapBuildApp::addOptions(CommandLine& line) {
  line.addArgument("SEQUENCE", sequence_);
  line.addOption("output,o", map_, "MAP.flmap", "The map to write.");
  line.addOption("poses", poses_, "FILE",
                 "Camera poses: stamp tx ty tz qx qy qz qw, or another format of RECORDINGS.md.");
  line.addSwitch("without-poses", without_poses_,
                 "Estimate the trajectory from the images, even if the SEQUENCE has poses.");
  line.addOption("trajectory", trajectory_, "OUT.txt",
                 "Write the pose of each image used, in the TUM format.");
  line.addOption("pose-tolerance", pose_tolerance_, "S", "Maximum time between an image and its pose [s].");
  line.addCheck([this] { requireTolerance(pose_tolerance_); });
  gravity_.addOptions(line);
  line.addOption("every", every_, "N", "Make each N-th image a local model, whatever its pose; 0 = off.");
  line.addSwitch("overwrite", overwrite_, "Replace an existing map.");
  line.addSwitch("resume", resume_, "Continue an existing map.");
  line.addSwitch("raw-depth", raw_depth_, "Do not estimate and remove the depth distortion of the camera.");
  line.addSwitch("force", force_, "Build the map even if images or poses are found to be wrong.");
  line.addPresets();
  addRecordingOptions(line, input_.recording);
  input_.addOptions(line);
  line.addParams(builder_, "map", CommandLine::Shown::in_help);
  by_images_.addOptions(line);
  line.addExample("walk -o office.flmap", "by the recording's poses, or by its images");
  line.addExample("walk -o office.flmap --without-poses", "by its images alone");
}

MapMaking MapBuildApp::makingOf(const DepthSequence& sequence, const Camera& camera, const Console& console) {
  std::string remark;
  if (!poses_.empty())
    given_ = sequence.readPoses(poses_, &remark);
  else if (!without_poses_)
    given_ = sequence.groundTruth();
  if (!remark.empty()) console.note(remark);
  MapMakingParams params;
  params.places = builder_;
  params.trajectory = by_images_.params();
  params.view = input_.view;
  params.every = every_;
  params.distortion = !raw_depth_;
  MapMaking making(camera, params);
  making.setNumberOfThreads(threads());
  for (std::size_t i = 0; i < sequence.frames().size(); ++i)
    making.add(mapImage(sequence, i, input_.width, given_.at(sequence.frames()[i].stamp, pose_tolerance_),
                        gravity_.at(sequence.frames()[i].stamp)));
  if (!given_.empty()) making.setPosesByTime([this](double stamp) { return given_.interpolated(stamp); });
  return making;
}

/** \return kFailed if images could not be read. */
int MapBuildApp::findTrajectory(const DepthSequence& sequence, MapMaking& making,
                                const Console& console) const {
  if (!given_.empty() || every_ > 0 || !poses_.empty()) return kOk;
  console.note("no poses are given: the trajectory is found from the images");
  making.setOdometry(by_images_.odometry(sequence, making.camera(), console));
  making.findTrajectory();
  const int code = by_images_.report(making.findings(), sequence, console);
  noteTrajectory(*making.findings().trajectory, console);
  return code;
}

void MapBuildApp::noteTrajectory(const CameraTrajectory& trajectory, const Console& console) const {
  console.out << "trajectory: " << toString(trajectory) << "; " << trajectory.overlaps.toString() << "\n";
  if (trajectory.cut_bonds > 0)
    console.note(
        fmt::format("{} between pieces of the trajectory taken out, which overlapping images contradict",
                    counted(static_cast<std::size_t>(trajectory.cut_bonds), "bond")));
  const std::vector<int> parts = trajectory.parts();
  if (parts.size() < 2) return;
  std::size_t outside = 0;
  for (const TrajectoryPose& pose : trajectory.images)
    outside += trajectory.keyframes[pose.keyframe].part != parts.front();
  console.note(fmt::format("the images are not all connected: {} in {} that nothing ties to the largest one; "
                           "their local models have no pose in its world",
                           counted(outside, "image"), counted(parts.size() - 1, "piece")));
}

void MapBuildApp::noteDistortion(const MapFindings& findings, const Console& console) const {
  const auto& found = findings.distortion;
  if (!found || found->reliable()) return;
  if (findings.trajectory) {
    console.note(fmt::format("the distortion of the camera is not estimated: the trajectory is accurate to "
                             "{:.2f} deg, {:.0f} mm only",
                             found->poses.rotation_std / kDegree, 1e3 * found->poses.translation_std));
    return;
  }
  console.note(fmt::format(
      "the distortion of the camera is not removed: the poses disagree too much with the images ({:.2f} deg, "
      "{:.0f} mm) to find it",
      found->poses.rotation_std / kDegree, 1e3 * found->poses.translation_std));
}

void MapBuildApp::writeTrajectory(const DepthSequence& sequence, const MapMaking& making) const {
  if (trajectory_.empty()) return;
  std::vector<StampedPose> poses;
  for (std::size_t i = 0; i < sequence.frames().size(); ++i)
    if (const auto T_w_c = making.pose(i)) poses.push_back({sequence.frames()[i].stamp, *T_w_c});
  writeTumTrajectory(trajectory_, poses);
}

/** Reports faults of the reading of images. Throws IoError if they cannot be right. */
void MapBuildApp::checkReading(const DepthSequence& sequence, MapMaking& making,
                               const Console& console) const {
  const auto tell = [&](const std::string& fault, bool impossible) {
    if (impossible && !force_)
      throw IoError(sequence_,
                    "cannot be right as it is read: " + fault + "; --force builds the map nevertheless");
    console.note(fault);
  };
  if (!canBeReadAgain(sequence)) return;
  if (sequence.camera()) {
    const ValueCheck values = checkValues(depthValues(sequence), sequence.camera()->depth_scale);
    for (const std::string& fault : values.faults) tell(fault, values.impossible);
    const Intrinsics& optics = sequence.camera()->camera.intrinsics;
    if (const std::string fault = opticsFault(optics); !fault.empty()) tell(fault, true);
  }
  making.checkGeometry();
  for (const ReadingFault& fault : making.findings().geometry->faults) tell(fault.words, fault.impossible);
}

/** Reports how much the poses disagree with the images, and likely causes. \return the
 * disagreement in words, empty if unknown. Throws IoError if no map can be made of such poses.
 */
std::string MapBuildApp::checkPoses(const DepthSequence& sequence, MapMaking& making,
                                    const Console& console) const {
  if (given_.empty() || !sequence.stamped() || !canBeReadAgain(sequence)) return {};
  making.checkPoses();
  const PoseCheck& check = *making.findings().poses;
  if (!check.isKnown()) return {};
  if (!check.cause.empty()) {
    const std::string mended = check.mended.toString(), as_given = check.as_given.toString();
    console.note(fmt::format("the poses disagree with the images by {}; {}{}", as_given, check.cause,
                             mended == as_given ? "" : "; so read, they disagree by " + mended) +
                 adviceOnPoses(check));
  }
  if (check.isBeyondSense() && !force_)
    throw IoError(
        poses_.empty() ? sequence_ : poses_,
        fmt::format("its poses are not those of its images: they disagree by {}{}; --force builds the map "
                    "nevertheless",
                    check.as_given.toString(),
                    check.cause.empty() ? "; look at fx, fy and depth_scale of camera.ini, too" : ""));
  return check.as_given.toString();
}

/** Throws IoError if there are none. */
std::vector<MapPlace> MapBuildApp::placesOf(const DepthSequence& sequence, const MapMaking& making) const {
  const bool asks_for_poses = !making.findings().trajectory && (every_ == 0 || !poses_.empty());
  if (asks_for_poses && !sequence.stamped())
    throw IoError(sequence_, "its image names are no time stamps: poses cannot be matched");
  if (asks_for_poses && every_ == 0 && given_.empty()) throw IoError(poses_, "has no poses");
  std::vector<MapPlace> places = making.places();
  if (places.empty())
    throw IoError(sequence_, fmt::format("none of its images has a pose within {:.9g} s", pose_tolerance_));
  return places;
}

/** A remark on images without a pose, unless none was given. */
void MapBuildApp::noteWithoutPose(const DepthSequence& sequence, const MapMaking& making,
                                  const Console& console) const {
  if (making.findings().trajectory) return;
  std::size_t without = 0;
  for (std::size_t i = 0; i < sequence.frames().size(); ++i) without += !making.pose(i);
  if (without > 0)
    console.note(
        fmt::format("{} without a pose within {:.9g} s", counted(without, "image"), pose_tolerance_));
}

/** Poses that fit few images and cannot be checked may be those of other images, by an invalid clock. */
void MapBuildApp::requireMostPosed(const DepthSequence& sequence, const MapMaking& making) const {
  if (given_.empty() || force_ || !disagreement_.empty()) return;
  const std::size_t all = sequence.frames().size();
  std::size_t without = 0;
  for (std::size_t i = 0; i < all; ++i) without += !making.pose(i);
  if (2 * without <= all || without == all) return;
  throw IoError(
      poses_.empty() ? sequence_ : poses_,
      fmt::format("{} of {} have no pose within {:.9g} s, and the others show too few motions to check their "
                  "poses by: are the times of images and poses those of one clock (--time-offset)? Is "
                  "--pose-tolerance too small? --force builds the map nevertheless",
                  without, counted(all, "image"), pose_tolerance_));
}

/** Were the local models that are there already made of the same images, with the same poses? */
bool MapBuildApp::madeOf(const Map& present, const DepthSequence& sequence,
                         const std::vector<MapPlace>& places) const {
  std::map<std::string, const MapPlace*> by_name;
  for (const MapPlace& place : places) by_name[sequence.frames()[place.image].name] = &place;
  const auto recorded = present.meta.find(kImagesKey);
  const ImageSizes sizes = recorded == present.meta.end() ? ImageSizes() : imageSizes(recorded->second);
  return std::all_of(present.models.begin(), present.models.end(), [&](const LocalModel& model) {
    const auto place = by_name.find(model.name);
    const auto size = sizes.find(model.name);
    if (place == by_name.end() || size == sizes.end()) return false;
    const auto& [image, T_w_m] = *place->second;
    return size->second == sizeOf(sequence.frames()[image]) && samePose(model.givenPose(), T_w_m);
  });
}

MapDatabase MapBuildApp::openDatabase(const fs::path& path, const DepthSequence& sequence,
                                      const std::vector<MapPlace>& places, const std::string& parameters,
                                      const Camera& camera) const {
  if (!resume_ || !isThere(path)) return createDatabase(path, sequence, parameters, camera, overwrite_);
  const Map present = openMap(path);
  if (present.models.empty())
    return createDatabase(path, sequence, parameters, camera, true);  // killed before it began
  const auto recorded = present.meta.find(kParametersKey);
  if (recorded == present.meta.end() || recorded->second != parameters || !madeOf(present, sequence, places))
    throw IoError(map_,
                  "was built of other images, with other poses or other parameters; give the same ones, or "
                  "--overwrite");
  MapDatabase database = MapDatabase::open(path);
  const std::string images = toText(imageSizes(sequence));  // some may have been repaired since
  if (images != present.meta.at(kImagesKey)) database.setMeta(kImagesKey, images);
  return database;
}

MapDatabase MapBuildApp::createDatabase(const fs::path& path, const DepthSequence& sequence,
                                        const std::string& parameters, const Camera& camera,
                                        bool overwrite) const {
  if (isThere(path) && !overwrite)
    throw IoError(map_, "exists already; give --overwrite to replace it or --resume to go on");
  MapDatabase database = MapDatabase::create(path, true);
  database.setMeta("software", versionText());
  database.setMeta("source", sequence_);
  database.setCamera(camera);
  database.setMeta(kParametersKey, parameters);
  database.setMeta(kImagesKey, toText(imageSizes(sequence)));
  if (!disagreement_.empty()) database.setMeta("poses disagree with images by", disagreement_);
  database.setMeta(kStateKey, kUnderWay);
  return database;
}

MapBuildApp::ModelBatch::Work MapBuildApp::modelWork(const DepthSequence& sequence, Camera camera,
                                                     const ModelsOrder& order, int workers) const {
  camera.distortion = order.second;
  const auto builders = std::make_shared<std::vector<ViewBuilder>>(workers, ViewBuilder(camera, input_.view));
  const auto fileOf = [&sequence, images = order.first](std::size_t i) -> const FrameFile& {
    return sequence.frames()[images[i]];
  };
  return {[fileOf](std::size_t i) { return fileOf(i).path.string(); },
          [this, &sequence, fileOf, builders, images = order.first](std::size_t i, int worker) {
            return packed({fileOf(i).name, fileOf(i).stamp},
                          (*builders)[worker].build(sequence.load(images[i], input_.width),
                                                    gravity_.at(fileOf(i).stamp)));
          }};
}

/** Adds the local models that are not there already, in order. \return the index of each place's. */
std::vector<int> MapBuildApp::addModels(const DepthSequence& sequence, const std::vector<MapPlace>& places,
                                        const Camera& camera, ModelBatch& batch, MapFile& file,
                                        Seen& seen) const {
  std::map<std::string, int> present;
  for (const std::string& name : file.modelNames()) present.emplace(name, static_cast<int>(present.size()));
  std::vector<int> models(places.size(), -1);
  std::vector<std::size_t> missing, images;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto found = present.find(sequence.frames()[places[i].image].name);
    if (found != present.end()) {
      models[i] = found->second;
    } else {
      missing.push_back(i);
      images.push_back(places[i].image);
    }
  }
  seen.models = present.size();
  batch.run({images, camera.distortion}, images.size(),
            [&](std::size_t i, std::optional<PackedModel>&& built, const std::string&) {
              if (!built) return;
              built->model.T_w_m = places[missing[i]].T_w_m;
              seen.noise.push_back(built->view.noise());
              if (built->view.segments.empty()) {
                ++seen.without_segments;
                return;
              }
              models[missing[i]] = file.add(*built);
              ++seen.added, ++seen.models;
            });
  return models;
}

/** \param path of the map until it is whole. \return the exit code. Throws IoError, and
 * leaves no map, if there would be nothing in it. */
int MapBuildApp::build(const fs::path& path, const DepthSequence& sequence,
                       const std::vector<MapPlace>& places, MapMaking& making, ModelBatch& batch,
                       const Console& console) const {
  const std::string parameters = cameraLine(sequence.camera()) +
                                 fmt::format("every = {}\nraw-depth = {:d}\n", every_, raw_depth_) +
                                 gravity_.toIni() + toIni(input_, making.camera()) + toIni(builder_, "map") +
                                 (making.findings().trajectory ? by_images_.toIni() : "");
  MapFile file(path, openDatabase(path, sequence, places, parameters, making.camera()), console);
  const bool begins = file.modelNames().empty();
  Seen seen;
  int code = kOk;
  const bool made = making.finish(file, [&](const std::vector<MapPlace>& of_map) {
    if (begins && !raw_depth_) noteDistortion(making.findings(), console);
    const std::vector<int> models = addModels(sequence, of_map, making.camera(), batch, file, seen);
    code = batch.report();
    noteWithoutPose(sequence, making, console);
    if (seen.without_segments > 0)
      console.note(counted(seen.without_segments, "image") + " without segments left out");
    noteNoise(seen.noise, making.camera().noise, console);
    return models;
  });
  if (!made) {
    fs::remove(path);
    throw IoError(map_, "is not written: none of the images makes a local model");
  }
  if (!disagreement_.empty()) console.out << "poses and images disagree by " << disagreement_ << "\n";
  console.out << counted(seen.added, "local model") << " added from "
              << counted(sequence.frames().size(), "image") << ", " << seen.models << " in all; map in "
              << map_ << "\n";
  return code;
}

int MapBuildApp::execute(const CommandLine& line, const Console& console) {
  if (map_.empty()) throw UsageError("the map to write is missing: -o MAP.flmap");
  if (every_ < 0) throw UsageError("every must not be negative");
  if (overwrite_ && resume_) throw UsageError("overwrite and resume exclude each other");
  const DepthSequence sequence = openSequence(sequence_, input_.recording, console);
  const Camera camera = input_.camera(sequence.camera(), line);
  gravity_.read(sequence, console);
  ModelBatch batch(threads(), console, [this, &sequence, camera](const ModelsOrder& order, int workers) {
    return modelWork(sequence, camera, order, workers);
  });
  if (batch.helped()) return kOk;
  MapMaking making = makingOf(sequence, camera, console);
  MapWatch watch(console);
  making.setProgress(watch.callback());
  const OutputLock lock = OutputLock::ofFile(map_);
  const bool goes_on = resume_ && isThere(map_) && !MapDatabase::open(map_).modelNames().empty();
  if (!goes_on) checkReading(sequence, making, console);
  int code = findTrajectory(sequence, making, console);
  writeTrajectory(sequence, making);
  if (!goes_on) {
    disagreement_ = checkPoses(sequence, making, console);
    requireMostPosed(sequence, making);
  }
  const std::vector<MapPlace> places = placesOf(sequence, making);
  const auto buildAt = [&](const fs::path& path) {
    code = std::max(code, build(path, sequence, places, making, batch, console));
  };
  if (overwrite_ && isThere(map_)) {
    openMap(map_);  // throws for a file that is no map, which is left alone
    replaceMap(map_, buildAt);
    return code;
  }
  const bool is_new = !isThere(map_);
  try {
    buildAt(map_);
  } catch (...) {
    if (is_new) removeWithoutModels(map_);
    throw;
  }
  return code;
}

}  // namespace facetloc
