// SPDX-License-Identifier: BSD-3-Clause
#include "base/ambiguity_file.h"
#include "base/batch.h"
#include "base/place_index_file.h"
#include "base/provenance.h"
#include "base/text.h"
#include "tools/map_apps.h"
#include "tools/seen_motions.h"

#include <facetloc/io/error.h>
#include <facetloc/io/output_lock.h>
#include <facetloc/io/text.h>
#include <facetloc/mapping/distortion_calibration.h>
#include <facetloc/mapping/found_mounting.h>
#include <facetloc/mapping/trajectory_links.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <utility>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

constexpr const char* kParametersKey = "parameters";
constexpr double kSamePose = 1e-9;  // [m], and of the entries of a rotation: what a file may round
constexpr std::size_t kCalibrationImages = 200;  // at most

bool samePose(const std::optional<Eigen::Isometry3d>& a, const std::optional<Eigen::Isometry3d>& b) {
  if (!a || !b) return !a && !b;
  return (a->matrix() - b->matrix()).cwiseAbs().maxCoeff() < kSamePose;
}

// An empty file holds nothing that could be lost.
bool isThere(const fs::path& path) {
  return fs::exists(path) && !(fs::is_regular_file(path) && fs::file_size(path) == 0);
}

// Of a camera whose mounting nobody has given: by the floor under a robot.
void noteMounting(const fs::path& path, const Console& console) {
  const Map map = openMap(path);
  if (map.camera.mounting) return;
  const auto found = findMounting(map);
  if (!found) return;
  Camera camera = map.camera;
  camera.mounting = found->mounting;
  MapDatabase::open(path).setCamera(camera);
  console.out << "the camera is mounted " << found->inWords() << "\n";
}

// Of a build that came to nothing.
void removeWithoutModels(const fs::path& path) try {
  if (openMap(path).models.empty()) fs::remove(path);
} catch (const std::exception&) {  // what ended the build is reported
}

}  // namespace

struct MapBuildApp::Candidate {
  std::size_t frame;
  std::optional<Eigen::Isometry3d> T_w_m;
};

struct MapBuildApp::Selection {
  std::vector<Candidate> candidates;
  std::size_t without_pose = 0;
};

/** What the images of new local models were like. */
struct MapBuildApp::Seen {
  std::vector<double> noise;  // of each [1/m]
  std::size_t without_segments = 0;
};

/** Adds local models in order, and a link from each to the next. What the map has already is left alone. */
class MapBuildApp::Writer {
public:
  /** \param links whether each model is linked with the one before by the rule's own link */
  Writer(MapDatabase database, const Map& present, const MapBuilder& builder, bool links)
      : database_(std::move(database)), builder_(builder), adds_links_(links) {
    for (std::size_t i = 0; i < present.models.size(); ++i)
      index_[present.models[i].name] = static_cast<int>(i);
    for (const Link& link : present.links) links_.emplace(link.from, link.to);
    const auto state = present.meta.find(kStateKey);
    whole_ = state == present.meta.end() || state->second == kWhole;
  }

  bool has(const std::string& name) const { return index_.count(name) > 0; }
  std::size_t added() const { return added_; }
  std::size_t models() const { return index_.size(); }
  std::vector<std::string> names() const { return database_.modelNames(); }

  void add(const PackedModel& packed) {
    if (std::exchange(whole_, false)) database_.setMeta(kStateKey, kUnderWay);
    const LocalModel& model = packed.model;
    index_[model.name] = database_.add(packed);
    ++added_;
    advance(model.name, model.T_w_m);
  }
  /** Goes on to a model, new or present. */
  void advance(const std::string& name, const std::optional<Eigen::Isometry3d>& T_w_m) {
    const int current = index_.at(name);
    if (adds_links_ && latest_ >= 0 && T_w_latest_ && T_w_m && links_.emplace(latest_, current).second)
      database_.add(builder_.link(latest_, current, *T_w_latest_, *T_w_m));
    latest_ = current;
    T_w_latest_ = T_w_m;
  }
  void add(const std::vector<Link>& links) {
    for (const Link& link : links)
      if (links_.emplace(link.from, link.to).second) database_.add(link);
  }
  void finish() {
    if (!std::exchange(whole_, true)) database_.setMeta(kStateKey, kWhole);
  }

private:
  MapDatabase database_;
  const MapBuilder& builder_;
  bool adds_links_;
  std::map<std::string, int> index_;
  std::set<std::pair<int, int>> links_;
  int latest_ = -1;
  std::optional<Eigen::Isometry3d> T_w_latest_;
  std::size_t added_ = 0;
  bool whole_ = true;
};

MapBuildApp::MapBuildApp()
    : App("facetloc_map build", "SEQUENCE -o MAP.flmap [options]",
          "Builds a map of local models from one recording. Its camera poses come with the SEQUENCE or from "
          "--poses; without either, they are found from the images themselves. The first image becomes a "
          "local "
          "model, and so does each later one that lies --map.distance or --map.rotation_deg from the latest "
          "one. Under mpirun, the images are dealt out to its processes.") {}

void MapBuildApp::addOptions(CommandLine& line) {
  line.addArgument("SEQUENCE", sequence_);
  line.addOption("output,o", map_, "MAP.flmap", "The map to write.");
  line.addOption("poses", poses_, "FILE", "Camera poses in the TUM format: stamp tx ty tz qx qy qz qw.");
  line.addSwitch("without-poses", without_poses_,
                 "Find the trajectory from the images, even if the SEQUENCE has poses.");
  line.addOption("trajectory", trajectory_, "OUT.txt",
                 "Write the pose of each image that the map was made with, in the TUM format.");
  line.addOption("pose-tolerance", pose_tolerance_, "S",
                 "Largest distance in time of an image and its pose [s].");
  line.addCheck([this] { requireTolerance(pose_tolerance_); });
  line.addOption("every", every_, "N", "Make each N-th image a local model, whatever its pose; 0 = off.");
  line.addSwitch("overwrite", overwrite_, "Replace a map that is there already.");
  line.addSwitch("resume", resume_, "Go on with a map that is there already.");
  line.addSwitch("raw-depth", raw_depth_,
                 "Leave in what the camera always measures wrongly at the same place of its image.");
  line.addSwitch("force", force_, "Build the map although the poses are not those of the images.");
  line.addPresets();
  addRecordingOptions(line, input_.recording);
  input_.addOptions(line);
  line.addParams(builder_, "map", CommandLine::Shown::in_help);
  by_images_.addOptions(line);
}

/** Given, or found from the images; then, what the camera always measures wrongly is found in turn with the
 * trajectory. */
void MapBuildApp::findPoses(const DepthSequence& sequence, Camera& camera, const Console& console) {
  if (!poses_.empty())
    poses_of_images_ = sequence.readPoses(poses_);
  else if (!without_poses_)
    poses_of_images_ = sequence.groundTruth();
  if (!poses_of_images_.empty() || every_ > 0 || !poses_.empty()) return;
  console.note("no poses are given: the trajectory is found from the images");
  for (const bool again : {false, true}) {
    FoundTrajectory found = by_images_.find(sequence, input_, camera, threads(), console);
    if (!again) unread_ = found.report(console);
    found_ = std::move(found.trajectory);
    if (again || raw_depth_) break;
    const auto distortion = calibrate(sequence, camera, console);
    if (!distortion) break;
    camera.distortion = distortion;
  }
  noteTrajectory(console);
}

std::optional<Eigen::Isometry3d> MapBuildApp::poseOf(const FrameFile& frame, std::size_t index) const {
  if (!found_) return poses_of_images_.at(frame.stamp, pose_tolerance_);
  const TrajectoryPose& pose = found_->images[index];
  if (found_->keyframes[pose.keyframe].part != found_->parts().front()) return {};
  return pose.T_w_c;
}

void MapBuildApp::noteTrajectory(const Console& console) const {
  console.out << "trajectory: " << inWords(*found_) << "\n";
  const std::vector<int> parts = found_->parts();
  if (parts.size() < 2) return;
  std::size_t outside = 0;
  for (const TrajectoryPose& pose : found_->images)
    outside += found_->keyframes[pose.keyframe].part != parts.front();
  console.note("the images do not hang together: " + counted(outside, "image") + " in " +
               counted(parts.size() - 1, "piece") +
               " that nothing ties to the largest one; their local models have no pose in its world");
}

void MapBuildApp::writeTrajectory(const DepthSequence& sequence) const {
  if (trajectory_.empty()) return;
  std::vector<StampedPose> poses;
  for (std::size_t i = 0; i < sequence.frames().size(); ++i)
    if (const auto T_w_c = poseOf(sequence.frames()[i], i))
      poses.push_back({sequence.frames()[i].stamp, *T_w_c});
  writeTumTrajectory(trajectory_, poses);
}

/** Says how far the poses are from what the images show, and what is wrong with them. \return the
 * disagreement in words, empty if nothing is known of it. Throws IoError if no map can be made of such poses.
 */
std::string MapBuildApp::checkPoses(const DepthSequence& sequence, const Camera& camera,
                                    const Console& console) const {
  const Trajectory& trajectory = poses_of_images_;
  if (trajectory.empty() || !sequence.stamped()) return {};
  const PoseCheck check = facetloc::checkPoses(seenMotions(sequence, camera, input_, threads(), console),
                                               [&](double stamp) { return trajectory.interpolated(stamp); });
  if (!check.isKnown()) return {};
  if (!check.cause.empty())
    console.note("the poses disagree with the images by " + check.as_given.inWords() + "; " + check.cause +
                 "; so read, they disagree by " + check.mended.inWords());
  if (check.isBeyondSense() && !force_)
    throw IoError(poses_.empty() ? sequence_ : poses_,
                  "its poses are not those of its images: they disagree by " + check.as_given.inWords() +
                      (check.cause.empty() ? "; look at fx, fy and depth_scale of camera.ini, too" : "") +
                      "; --force builds the map nevertheless");
  return check.as_given.inWords();
}

MapBuildApp::Selection MapBuildApp::select(const DepthSequence& sequence) const {
  const bool asks_for_poses = !found_ && (every_ == 0 || !poses_.empty());
  if (asks_for_poses && !sequence.stamped())
    throw IoError(sequence_, "its image names are no time stamps: poses cannot be matched");
  if (asks_for_poses && every_ == 0 && poses_of_images_.empty()) throw IoError(poses_, "has no poses");
  Selection selection;
  std::map<int, MapBuilder> rules;  // of each part
  for (std::size_t i = 0; i < sequence.frames().size(); ++i) {
    const auto pose = poseOf(sequence.frames()[i], i);
    if (!pose) ++selection.without_pose;
    const int part = found_ ? found_->keyframes[found_->images[i].keyframe].part : 0;
    MapBuilder& rule = rules.try_emplace(part, builder_).first->second;
    const auto by_rule = found_ ? std::optional(found_->images[i].T_w_c) : pose;
    const bool accepted = every_ > 0 ? i % every_ == 0 : by_rule && rule.accept(*by_rule);
    if (accepted) selection.candidates.push_back({i, pose});
  }
  if (found_) selection.without_pose = 0;  // as the trajectory knows
  if (selection.candidates.empty())
    throw IoError(sequence_,
                  "none of its images has a pose within " + text::significant(pose_tolerance_) + " s");
  return selection;
}

/** Were the local models that are there already made of the same images, with the same poses? */
bool MapBuildApp::madeOf(const Map& present, const DepthSequence& sequence,
                         const std::vector<Candidate>& candidates) const {
  std::map<std::string, const Candidate*> by_name;
  for (const Candidate& c : candidates) by_name[sequence.frames()[c.frame].name] = &c;
  const auto recorded = present.meta.find(kImagesKey);
  const ImageSizes sizes = recorded == present.meta.end() ? ImageSizes() : imageSizes(recorded->second);
  return std::all_of(present.models.begin(), present.models.end(), [&](const LocalModel& model) {
    const auto candidate = by_name.find(model.name);
    const auto size = sizes.find(model.name);
    if (candidate == by_name.end() || size == sizes.end()) return false;
    const auto& [frame, T_w_m] = *candidate->second;
    return size->second == sizeOf(sequence.frames()[frame]) && samePose(model.givenPose(), T_w_m);
  });
}

MapDatabase MapBuildApp::openDatabase(const fs::path& path, const DepthSequence& sequence,
                                      const std::vector<Candidate>& candidates, const std::string& parameters,
                                      const Camera& camera) const {
  if (!resume_ || !isThere(path)) return createDatabase(path, sequence, parameters, camera, overwrite_);
  const Map present = openMap(path);
  if (present.models.empty())
    return createDatabase(path, sequence, parameters, camera, true);  // killed before it began
  const auto recorded = present.meta.find(kParametersKey);
  if (recorded == present.meta.end() || recorded->second != parameters ||
      !madeOf(present, sequence, candidates))
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

/** Of a trajectory found from the images. \param names of the local models, by index */
std::vector<Link> MapBuildApp::linksOf(const DepthSequence& sequence,
                                       const std::vector<std::string>& names) const {
  std::map<std::string, int> index;
  for (std::size_t i = 0; i < names.size(); ++i) index[names[i]] = static_cast<int>(i);
  std::vector<std::size_t> images;
  std::vector<int> models;
  for (std::size_t i = 0; i < sequence.frames().size(); ++i)
    if (const auto model = index.find(sequence.frames()[i].name); model != index.end()) {
      images.push_back(i);
      models.push_back(model->second);
    }
  std::vector<Link> links = trajectoryLinks(*found_, images);
  for (Link& link : links) link.from = models[link.from], link.to = models[link.to];
  return links;
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
            LocalModel model{fileOf(i).name, fileOf(i).stamp, {}, {}};
            model.view = (*builders)[worker].build(sequence.load(images[i], input_.width));
            return packed(std::move(model));
          }};
}

/** Adds the local models of candidates in order, those that are there already among them. */
MapBuildApp::Seen MapBuildApp::addModels(const DepthSequence& sequence,
                                         const std::vector<Candidate>& candidates, const Camera& camera,
                                         ModelBatch& batch, Writer& writer) const {
  const auto nameOf = [&](const Candidate& c) { return sequence.frames()[c.frame].name; };
  std::vector<std::size_t> images;
  for (const Candidate& c : candidates)
    if (!writer.has(nameOf(c))) images.push_back(c.frame);
  auto next = candidates.begin();
  const auto advance = [&] {
    for (; next != candidates.end() && writer.has(nameOf(*next)); ++next)
      writer.advance(nameOf(*next), next->T_w_m);
  };
  Seen seen;
  batch.run({images, camera.distortion}, images.size(),
            [&](std::size_t, std::optional<PackedModel>&& built, const std::string&) {
              advance();
              const Candidate& candidate = *next++;
              if (!built) return;
              built->model.T_w_m = candidate.T_w_m;
              seen.noise.push_back(built->model.view.noise());
              if (built->model.view.segments.empty())
                ++seen.without_segments;
              else
                writer.add(*built);
            });
  advance();
  return seen;
}

/** What the camera always measures wrongly, from images of the whole run; the same for any number of threads.
 */
std::optional<DepthDistortion> MapBuildApp::calibrate(const DepthSequence& sequence, const Camera& camera,
                                                      const Console& console) const {
  std::vector<Candidate> posed;
  for (std::size_t i = 0; i < sequence.frames().size(); ++i)
    if (const auto pose = poseOf(sequence.frames()[i], i)) posed.push_back({i, pose});
  const std::size_t n = std::min(posed.size(), kCalibrationImages);
  std::vector<DepthPicture> depth(n);
  std::vector<PosedPicture> pictures;
  for (std::size_t i = 0; i < n; ++i) pictures.push_back({&depth[i], *posed[i * posed.size() / n].T_w_m});
  const auto frameOf = [&](std::size_t i) { return posed[i * posed.size() / n].frame; };
  // Images that cannot be read are left out: those that become local models are reported later.
  Batch(threads(), n, console)
      .run([&](std::size_t i) { return sequence.frames()[frameOf(i)].name; },
           [&](std::size_t i, int) { depth[i].assign(sequence.load(frameOf(i), input_.width)); });
  const auto found = calibrateDistortion(
      pictures, camera.noise, {builder_.pose_rotation_std_deg * kDegree, builder_.pose_translation_std});
  if (!found) return {};
  if (found->reliable()) return found->distortion;
  console.note("the distortion of the camera is left in: the poses are too far from what the images show (" +
               text::decimals(found->poses.rotation_std / kDegree, 2) + " deg, " +
               text::decimals(1e3 * found->poses.translation_std, 0) + " mm) to find it");
  return {};
}

/** \param path of the map until it is whole. \return the exit code. Throws IoError, and
 * leaves no map, if there would be nothing in it. */
int MapBuildApp::build(const fs::path& path, const DepthSequence& sequence, const Selection& selection,
                       Camera camera, ModelBatch& batch, const Console& console) const {
  const std::string parameters = cameraLine(sequence.camera()) + "every = " + std::to_string(every_) + "\n" +
                                 "raw-depth = " + (raw_depth_ ? "1" : "0") + "\n" + toIni(input_, camera) +
                                 toIni(builder_, "map") + (found_ ? by_images_.toIni() : "");
  MapDatabase database = openDatabase(path, sequence, selection.candidates, parameters, camera);
  const Map present = openMap(path);
  if (!present.models.empty())
    camera.distortion = present.camera.distortion;
  else if (!raw_depth_)
    camera.distortion = calibrate(sequence, camera, console);
  if (camera.distortion && present.models.empty()) database.setCamera(camera);
  const MapBuilder builder(builder_);
  Writer writer(std::move(database), present, builder, !found_);
  const Seen seen = addModels(sequence, selection.candidates, camera, batch, writer);

  const int code = std::max<int>(unread_, batch.report());
  if (selection.without_pose > 0)
    console.note(counted(selection.without_pose, "image") + " without a pose within " +
                 text::significant(pose_tolerance_) + " s");
  if (seen.without_segments > 0)
    console.note(counted(seen.without_segments, "image") + " without segments left out");
  noteNoise(seen.noise, camera.noise, console);
  if (writer.models() == 0) {
    fs::remove(path);
    throw IoError(map_, "is not written: none of the images makes a local model");
  }
  if (found_) writer.add(linksOf(sequence, writer.names()));
  writer.finish();
  noteMounting(path, console);
  writePlaceIndex(path);
  writeAmbiguity(path, threads(), console);
  if (!disagreement_.empty()) console.out << "poses and images disagree by " << disagreement_ << "\n";
  console.out << counted(writer.added(), "local model") << " added from "
              << counted(sequence.frames().size(), "image") << ", " << writer.models() << " in all; map in "
              << map_ << "\n";
  return code;
}

int MapBuildApp::execute(const CommandLine& line, const Console& console) {
  if (map_.empty()) throw UsageError("the map to write is missing: -o MAP.flmap");
  if (every_ < 0) throw UsageError("every must not be negative");
  if (overwrite_ && resume_) throw UsageError("overwrite and resume exclude each other");
  const DepthSequence sequence = openSequence(sequence_, input_.recording, console);
  Camera camera = input_.camera(sequence.camera(), line);
  ModelBatch batch(threads(), console, [this, &sequence, camera](const ModelsOrder& order, int workers) {
    return modelWork(sequence, camera, order, workers);
  });
  if (batch.helped()) return kOk;
  const OutputLock lock = OutputLock::ofFile(map_);
  findPoses(sequence, camera, console);
  writeTrajectory(sequence);
  const bool goes_on = resume_ && isThere(map_) && !MapDatabase::open(map_).modelNames().empty();
  if (!goes_on) disagreement_ = checkPoses(sequence, camera, console);
  const Selection selection = select(sequence);
  int code = kOk;
  const auto buildAt = [&](const fs::path& path) {
    code = build(path, sequence, selection, camera, batch, console);
  };
  if (overwrite_ && isThere(map_)) {
    openMap(map_);  // what is no map stays
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
