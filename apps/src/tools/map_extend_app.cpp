// SPDX-License-Identifier: BSD-3-Clause
#include "batch/map_watch.h"
#include "cli/text.h"
#include "cli/tools.h"
#include "inputs/depth_input.h"
#include "outputs/map_completion.h"
#include "outputs/provenance.h"
#include "tools/drawn_map.h"
#include "tools/image_trajectory.h"

#include <facetloc/features/map_parts.h>
#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>
#include <facetloc/io/map_database.h>
#include <facetloc/mapping/map_session.h>

#include <algorithm>
#include <fmt/core.h>
#include <optional>
#include <utility>
#include <vector>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostNamed = 12;  // local models that a line of the report names

std::string named(const std::vector<std::string>& names) {
  std::string words;
  for (std::size_t i = 0; i < std::min(names.size(), kMostNamed); ++i)
    words += (i > 0 ? ", " : "") + names[i];
  if (names.size() > kMostNamed) words += fmt::format(", and {} more", names.size() - kMostNamed);
  return words;
}

/** The changes, a line for each kind. */
void printChanges(std::ostream& out, const MapChanges& changes) {
  out << counted(changes.seen, "local model") << " seen again, of whose "
      << counted(changes.of_surfaces, "surface") << " " << changes.surfaces << " are gone\n";
  const auto line = [&](const std::string& what, const std::vector<std::string>& names) {
    if (!names.empty()) out << what << ": " << named(names) << "\n";
  };
  std::vector<std::string> replaced;
  for (const MapChanges::Replacement& r : changes.replaced)
    replaced.push_back(fmt::format("{} by {}", r.old_model, r.new_model));
  line("new local models", changes.added);
  line("replaced", replaced);
  line("retired", changes.retired);
  line("without moved surfaces", changes.edited);
}

/** facetloc_map extend: a later session is found in a map, and brings it up to date. */
class MapExtendApp : public App {
public:
  MapExtendApp()
      : App("facetloc_map extend", "MAP.flmap SEQUENCE [-o NEW.flmap] [options]",
            "Updates a map with a later session. Finds the session in the map, removes surfaces that its "
            "images look through, replaces local models that have lost much, and adds new places. The "
            "trajectory comes from the SEQUENCE's poses or from --poses, in any coordinates, or else from "
            "the images. If the session is not found in the map, the map is not changed.") {}

private:
  void addOptions(CommandLine& line) override {
    line.addArgument("MAP.flmap", map_);
    line.addArgument("SEQUENCE", sequence_);
    line.addOption("output,o", output_, "NEW.flmap", "The map to write; MAP.flmap itself unless given.");
    line.addOption("poses", poses_, "FILE",
                   "Camera poses: stamp tx ty tz qx qy qz qw, or another format of RECORDINGS.md.");
    addPoseTolerance(line, pose_tolerance_);
    line.addSwitch("without-poses", without_poses_,
                   "Estimate the trajectory from the images, even if the SEQUENCE has poses.");
    line.addOption("trajectory", trajectory_, "OUT.txt",
                   "Write the poses of the session in the map, in the TUM format.");
    line.addOption("changes", changes_, "OUT.png", "Draw the floor map with the changes.");
    line.addSwitch("overwrite", overwrite_, "Replace an existing NEW.flmap.");
    addRecordingOptions(line, input_.recording);
    input_.addOptions(line);
    line.addParams(builder_, "map");
    line.addParams(session_, "session", CommandLine::Shown::in_help);
    by_images_.addOptions(line);
    line.addExample("office.flmap later -o newer.flmap", "a new map");
    line.addExample("office.flmap later --changes changes.png", "with a picture of the changes");
  }

  /** Throws IoError for poses that cannot be matched with the images. */
  MapSession sessionIn(const std::shared_ptr<const Map>& map, const DepthSequence& sequence,
                       const Camera& camera, const Console& console) const {
    const Trajectory given = without_poses_ ? Trajectory() : givenPoses(sequence, poses_, console);
    const bool by_poses = !poses_.empty() || !given.empty();
    if (by_poses && !sequence.stamped())
      throw IoError(sequence_, "its image names are no time stamps: poses cannot be matched");

    MapUpdateParams params;
    params.session = session_;
    params.places = builder_;
    params.trajectory = by_images_.params();
    params.view = input_.view;
    MapSession session(map, camera, params);
    session.setNumberOfThreads(threads());
    bool has_pose = false;
    for (std::size_t i = 0; i < sequence.frames().size(); ++i) {
      const auto T_w_c = given.at(sequence.frames()[i].stamp, pose_tolerance_);
      has_pose = has_pose || T_w_c;
      session.add(mapImage(sequence, i, input_.width, T_w_c));
    }
    if (by_poses && !has_pose)
      throw IoError(sequence_, fmt::format("none of its images has a pose within {:f} s", pose_tolerance_));
    if (!by_poses) session.setOdometry(by_images_.odometry(sequence, camera, console));
    return session;
  }

  /** Throws IoError if the session is not in the map. */
  const SessionPlace& find(MapSession& session) const {
    const SessionPlace& place = session.find();
    if (!place.found())
      throw IoError(sequence_, fmt::format("is not found in {}, which stays as it is: {}, {} must", map_,
                                           place.toString(), session_.min_agreeing));
    return place;
  }

  void writeTrajectory(const MapSession& session) const {
    std::vector<StampedPose> poses;
    for (const TrajectoryPose& pose : session.poses()) poses.push_back({pose.stamp, pose.T_w_c});
    writeTumTrajectory(trajectory_, poses);
  }

  static void drawChanges(const std::string& map, const MapSession& session, const MapChanges& changes,
                          const DrawnMap& picture) {
    std::vector<Eigen::Isometry3d> T_w_c;
    for (const TrajectoryPose& pose : session.poses()) T_w_c.push_back(pose.T_w_c);
    picture.draw(map, T_w_c,
                 {{"new local models", changes.T_w_new},
                  {"without moved surfaces", changes.T_w_edited},
                  {"retired", changes.T_w_old}});
  }

  int execute(const CommandLine& line, const Console& console) override {
    if (without_poses_ && !poses_.empty()) throw UsageError("poses and without-poses exclude each other");
    std::optional<DrawnMap> picture;
    if (!changes_.empty()) picture.emplace(changes_);
    if (overwrite_ && output_.empty())
      throw UsageError("overwrite belongs to --output; without that, MAP.flmap itself is replaced");
    const std::string target = output_.empty() ? map_ : output_;
    if (!fs::is_regular_file(map_)) throw IoError(map_, "is not there");
    const OutputLock lock = lockTarget(target, output_.empty() || overwrite_);
    const auto map = std::make_shared<const Map>(noteUnfinished(readMap(map_), map_, console));
    if (!hasGivenPose(*map)) throw IoError(map_, "cannot be extended: no local model has a pose");
    const DepthSequence sequence = openSequence(sequence_, input_.recording, console);
    const Camera camera = map->calibrated(input_.camera(sequence.camera(), line));
    noteDifference(camera, *map, console);

    MapSession session = sessionIn(map, sequence, camera, console);
    MapWatch watch(console);
    session.setProgress(watch.callback());
    session.findTrajectory();
    const int code = by_images_.report(session.findings(), sequence, console);
    const SessionPlace& place = find(session);
    console.out << "the session is found in the map: " << place.toString() << "\n";
    const std::size_t lost = place.T_w_k.size() - session.placed();
    if (lost > 0)
      console.note(counted(lost, "keyframe") + " left out, whose place in the map is not certain");

    Map changed = *map;
    const MapChanges changes = session.update(changed);
    printChanges(console.out, changes);
    noteSession(fmt::format("{}: {}, {}; {}", sequence_, counted(sequence.frames().size(), "image"),
                            changes.toString(), versionText()),
                changed);
    replaceWholeMap(target, changed, threads(), console);
    if (!trajectory_.empty()) writeTrajectory(session);
    if (picture) drawChanges(target, session, changes, *picture);
    console.out << changes.toString() << "; map of " << counted(changed.models.size(), "local model")
                << " in " << target << "\n";
    return code;
  }

  std::string map_, sequence_, output_, poses_, trajectory_, changes_;
  double pose_tolerance_ = 0.02;
  bool overwrite_ = false, without_poses_ = false;
  DepthInput input_;
  MapBuilderParams builder_;
  MapSessionParams session_;
  ImageTrajectory by_images_;
};

}  // namespace

std::unique_ptr<App> mapExtendApp() { return std::make_unique<MapExtendApp>(); }

}  // namespace facetloc
