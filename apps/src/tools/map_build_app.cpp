// SPDX-License-Identifier: BSD-3-Clause
#include "batch/batch.h"
#include "batch/map_watch.h"
#include "batch/shared_batch.h"
#include "cli/text.h"
#include "cli/tools.h"
#include "inputs/depth_input.h"
#include "inputs/gravity_option.h"
#include "outputs/map_completion.h"
#include "outputs/provenance.h"
#include "tools/image_trajectory.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/depth_values.h>
#include <facetloc/io/error.h>
#include <facetloc/io/map_database.h>
#include <facetloc/mapping/map_making.h>

#include <algorithm>
#include <fmt/core.h>
#include <map>
#include <memory>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

// Removes the map of a build that came to nothing.
void removeWithoutModels(const fs::path& path) try {
  if (openMap(path).models.empty()) fs::remove(path);
} catch (const std::exception&) {  // the error that ended the build is reported
}

/** facetloc_map build: one run of depth images -> a map. */
class MapBuildApp : public App {
public:
  MapBuildApp()
      : App("facetloc_map build", "RECORDING -o MAP.flmap [options]",
            "Builds a map from a recording: local models, the planar segments of chosen images, and links "
            "between them. Poses come from the recording, from --poses, or from the images.") {}

private:
  using ModelBatch = SharedBatch<ModelsOrder, PackedModel>;

  /** Statistics of local models and their images. */
  struct Seen {
    std::size_t added = 0, models = 0;
    std::vector<double> noise;  // inverse-depth noise by image [1/m]
    std::size_t without_segments = 0;
  };

  void addOptions(CommandLine& line) override {
    line.addArgument("RECORDING", sequence_);
    line.addOption("output,o", map_, "MAP.flmap", "The map to write.");
    line.addOption("poses", poses_, "FILE",
                   "Camera poses: stamp tx ty tz qx qy qz qw, or another format of RECORDINGS.md.");
    line.addSwitch("without-poses", without_poses_,
                   "Estimate the trajectory from the images, even if the RECORDING has poses.");
    line.addOption("trajectory", trajectory_, "OUT.txt",
                   "Write the pose of each image used, in the TUM format.");
    addPoseTolerance(line, pose_tolerance_);
    gravity_.addOptions(line);
    line.addOption("every", params_.every, "N",
                   "Make each N-th image a local model, whatever its pose; 0 = off.");
    line.addSwitch("overwrite", overwrite_, "Replace an existing map.");
    line.addSwitch("resume", resume_, "Continue an existing map.");
    line.addSwitch("raw-depth", raw_depth_, "Do not estimate and remove the depth distortion of the camera.");
    line.addSwitch("force", force_, "Build the map even if images or poses are found to be wrong.");
    line.addPresets();
    input_.addAllOptions(line);
    line.addParams(params_.places, "map", CommandLine::Shown::in_help);
    by_images_.addOptions(line);
    line.addExample("walk -o office.flmap", "by the recording's poses, or by its images");
    line.addExample("walk -o office.flmap --without-poses", "by its images alone");
  }

  MapMaking makingOf(const DepthSequence& sequence, const Camera& camera, const Console& console) {
    if (!poses_.empty() || !without_poses_) given_ = givenPoses(sequence, poses_, console);
    params_.trajectory = by_images_.params();
    params_.view = input_.view;
    params_.distortion = !raw_depth_;
    MapMaking making(camera, params_);
    making.setNumberOfThreads(threads());
    addImages(sequence, given_,
              {input_.width, pose_tolerance_, [this](double stamp) { return gravity_.at(stamp); }}, making);
    return making;
  }

  /** Shows findings from a number on. Throws IoError if no map is to be made. */
  void judge(const Findings& findings, const Console& console, std::size_t first = 0) const {
    for (std::size_t i = first; i < findings.size(); ++i) {
      const Finding& finding = findings[i];
      if (finding.severity == Severity::refusal && !force_) {
        console.keep(finding);
        throw IoError(sequence_, fmt::format("cannot be right as it is read: {}; --force builds the map "
                                             "nevertheless",
                                             finding.text()));
      }
      finding.id == PoseCheck::kAccuracy ? console.keep(finding)
                                         : console.find(finding);  // it is among the results
    }
  }

  /** \return kFailed if images could not be read. */
  int findTrajectory(const DepthSequence& sequence, MapMaking& making, const Console& console) const {
    if (!given_.empty() || params_.every > 0 || !poses_.empty()) return kOk;
    console.note("no poses are given: the trajectory is found from the images");
    making.setOdometry(by_images_.odometry(sequence, making.camera(), console));
    making.findTrajectory();
    const int code = by_images_.report(making.findings(), sequence, console);
    const CameraTrajectory& found = *making.findings().trajectory;
    console.out << "trajectory: " << toString(found) << "; " << found.overlaps.toString() << "\n";
    return code;
  }

  void writeTrajectory(const DepthSequence& sequence, const MapMaking& making) const {
    if (trajectory_.empty()) return;
    std::vector<StampedPose> poses;
    for (std::size_t i = 0; i < sequence.frames().size(); ++i)
      if (const auto T_w_c = making.pose(i)) poses.push_back({sequence.frames()[i].stamp, *T_w_c});
    writeTumTrajectory(trajectory_, poses);
  }

  /** Throws IoError if there are none. */
  std::vector<MapPlace> placesOf(const DepthSequence& sequence, const MapMaking& making) const {
    const bool asks_for_poses = !making.findings().trajectory && (params_.every == 0 || !poses_.empty());
    if (asks_for_poses && !sequence.stamped())
      throw IoError(sequence_, "its image names are no time stamps: poses cannot be matched");
    if (asks_for_poses && params_.every == 0 && given_.empty()) throw IoError(poses_, "has no poses");
    std::vector<MapPlace> places = making.places();
    if (places.empty())
      throw IoError(sequence_, fmt::format("none of its images has a pose within {:.9g} s", pose_tolerance_));
    return places;
  }

  ModelBatch::Work modelWork(const DepthSequence& sequence, Camera camera, const ModelsOrder& order,
                             int workers) const {
    camera.distortion = order.second;
    const auto builders =
        std::make_shared<std::vector<ViewBuilder>>(workers, ViewBuilder(camera, input_.view));
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
  std::vector<int> addModels(const DepthSequence& sequence, const std::vector<MapPlace>& places,
                             const Camera& camera, ModelBatch& batch, MapFile& file, Seen& seen) const {
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
  int build(const fs::path& path, const DepthSequence& sequence, const std::vector<MapPlace>& places,
            MapMaking& making, ModelBatch& batch, const Console& console) const {
    const std::string parameters = cameraLine(sequence.camera()) +
                                   fmt::format("every = {}\nraw-depth = {:d}\n", params_.every, raw_depth_) +
                                   gravity_.toIni() + toIni(input_, making.camera()) +
                                   toIni(params_.places, "map") +
                                   (making.findings().trajectory ? by_images_.toIni() : "");
    const MapInputs inputs{map_, sequence_, sequence, places, parameters, disagreement_};
    MapFile file(path, openBuild(path, inputs, making.camera(), resume_, overwrite_), console);
    const bool begins = file.modelNames().empty();
    Seen seen;
    int code = kOk;
    const std::size_t known = making.findings().list().size();
    const bool made = making.finish(file, [&](const std::vector<MapPlace>& of_map) {
      if (begins) judge(making.findings().list(), console, known);
      const std::vector<int> models = addModels(sequence, of_map, making.camera(), batch, file, seen);
      code = batch.report();
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

  int execute(const CommandLine& line, const Console& console) override {
    if (map_.empty()) throw UsageError("the map to write is missing: -o MAP.flmap");
    if (params_.every < 0) throw UsageError("every must not be negative");
    if (overwrite_ && resume_) throw UsageError("overwrite and resume exclude each other");
    const DepthSequence sequence = DepthSequence::open(sequence_, input_.recording);
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
    force_ = force_ || goes_on;  // it was judged when it was begun
    judge(readingFindings(sequence), console);
    // A build that goes on divides the poses where it did.
    if (given_.empty() ? !goes_on : sequence.stamped()) checkRun(sequence, {}, making, force_);
    if (!force_ && firstOf(making.findings().list(), Severity::refusal))
      judge(making.findings().list(), console);
    int code = findTrajectory(sequence, making, console);
    writeTrajectory(sequence, making);
    if (!goes_on) judge(making.findings().list(), console);
    if (const auto& check = making.findings().poses; !goes_on && check && check->isKnown())
      disagreement_ = check->as_given.toString();
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

  bool dealsOut() const override { return true; }

  std::string disagreement_;  // between poses and images, as text
  Trajectory given_;          // poses of the images; empty if none are given
  std::string sequence_, map_, poses_, trajectory_;
  double pose_tolerance_ = 0.02;
  bool overwrite_ = false, resume_ = false, raw_depth_ = false, force_ = false, without_poses_ = false;
  ImageTrajectory by_images_;
  GravityOption gravity_;
  DepthInput input_;
  MapMakingParams params_;
};

}  // namespace

std::unique_ptr<App> mapBuildApp() { return std::make_unique<MapBuildApp>(); }

}  // namespace facetloc
