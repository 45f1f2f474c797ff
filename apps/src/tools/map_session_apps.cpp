// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "batch/map_watch.h"
#include "cli/text.h"
#include "cli/tools.h"
#include "drawing/map_page.h"
#include "inputs/depth_input.h"
#include "outputs/map_completion.h"
#include "tools/image_trajectory.h"

#include <facetloc/features/map_parts.h>
#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>
#include <facetloc/io/map_database.h>
#include <facetloc/mapping/map_session.h>

#include <algorithm>
#include <fmt/format.h>
#include <map>
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

constexpr std::size_t kMostListed = 40;  // surfaces that the table of changes has

/** The changed surfaces and their areas, kind by kind. */
void printSurfaces(std::ostream& out, const Map& map, const std::vector<SurfaceChange>& changes) {
  TextTable table({"surface", "area [m2]", "probability", "looks", "centre", "seen by", "part"});
  table.setWordsLast();
  std::map<std::string, std::pair<std::size_t, double>> sums = {{"removed", {}}, {"new", {}}};
  for (const SurfaceChange& c : changes) {
    auto& [n, area] = sums[c.name()];
    ++n, area += c.area;
    if (table.rows().size() <= kMostListed)
      table.add({c.name(), text::decimals(c.area, 2), text::decimals(c.probability, 3),
                 std::to_string(c.looks),
                 fmt::format("({:.2f}, {:.2f}, {:.2f})", c.centre.x(), c.centre.y(), c.centre.z()), c.seen_by,
                 map.parts.empty() ? "" : map.parts[static_cast<std::size_t>(c.part)]});
  }
  if (!changes.empty()) out << table;
  if (changes.size() > kMostListed) out << fmt::format("and {} more\n", changes.size() - kMostListed);
  for (const char* name : {"removed", "new"})
    out << fmt::format("{} {}, {:.2f} m2\n", counted(sums[name].first, "surface"), name, sums[name].second);
}

void writeSurfaces(const fs::path& path, const Map& map, const std::vector<SurfaceChange>& changes) {
  writeTextAtomically(path, [&](std::ostream& out) {
    const auto cells = [](const Eigen::Vector3d& p, char between) {
      return fmt::format("{:.3f}{}{:.3f}{}{:.3f}", p.x(), between, p.y(), between, p.z());
    };
    out << "surface,area_m2,probability,looks,part,seen_by,x,y,z,nx,ny,nz,outline\n";
    for (const SurfaceChange& c : changes) {
      std::vector<std::string> corners;
      for (const Eigen::Vector3d& p : c.outline) corners.push_back(cells(p, ' '));
      out << fmt::format("{},{:.4f},{:.4f},{},{},{},{},{},{}\n", c.name(), c.area, c.probability, c.looks,
                         text::csvCell(map.parts.empty() ? "" : map.parts[static_cast<std::size_t>(c.part)]),
                         text::csvCell(c.seen_by), cells(c.centre, ','), cells(c.normal, ','),
                         fmt::join(corners, "; "));
    }
  });
}

/** A later session that is found in a map. */
class MapSessionApp : public App {
protected:
  using App::App;

  void addSessionOptions(CommandLine& line) {
    line.addArgument("MAP.flmap", map_);
    line.addArgument("RECORDING", sequence_);
    line.addOption("poses", poses_, "FILE",
                   "Camera poses: stamp tx ty tz qx qy qz qw, or another format of RECORDINGS.md.");
    addPoseTolerance(line, pose_tolerance_);
    line.addSwitch("without-poses", without_poses_,
                   "Estimate the trajectory from the images, even if the RECORDING has poses.");
    line.addCheck([this] {
      if (without_poses_ && !poses_.empty()) throw UsageError("poses and without-poses exclude each other");
    });
    input_.addAllOptions(line);
    line.addParams(params_.places, "map");
    line.addParams(params_.session, "session", CommandLine::Shown::in_help);
    by_images_.addOptions(line);
  }

  std::shared_ptr<const Map> readMapWithPoses(const Console& console) const {
    const auto map = std::make_shared<const Map>(noteUnfinished(readMap(map_), map_, console));
    if (!hasGivenPose(*map)) throw IoError(map_, "takes no session: no local model has a pose");
    return map;
  }

  /** Throws IoError if the session is not in the map. */
  MapSession find(const std::shared_ptr<const Map>& map, const DepthSequence& sequence,
                  const CommandLine& line, const Console& console) {
    const Camera camera = map->calibrated(input_.camera(sequence.camera(), line));
    noteDifference(camera, *map, console);
    MapSession session = sessionIn(map, sequence, camera, console);
    MapWatch watch(console);
    session.setProgress(watch.callback());
    session.findTrajectory();
    code_ = by_images_.report(session.findings(), sequence, console);
    const SessionPlace& place = session.find();
    session.setProgress({});
    if (!place.found())
      throw IoError(sequence_, fmt::format("is not found in {}, which stays as it is: {}, {} must", map_,
                                           place.toString(), params_.session.min_agreeing));
    console.out << "the session is found in the map: " << place.toString() << "\n";
    const std::size_t lost = place.T_w_k.size() - session.placed();
    if (lost > 0)
      console.note(counted(lost, "keyframe") + " left out, whose place in the map is not certain");
    return session;
  }

  std::string map_, sequence_, poses_;
  DepthInput input_;
  int code_ = kOk;  // exit code by the trajectory

private:
  /** Throws IoError for poses that cannot be matched with the images. */
  MapSession sessionIn(const std::shared_ptr<const Map>& map, const DepthSequence& sequence,
                       const Camera& camera, const Console& console) const {
    const Trajectory given = without_poses_ ? Trajectory() : givenPoses(sequence, poses_, console);
    const bool by_poses = !poses_.empty() || !given.empty();
    if (by_poses && !sequence.stamped())
      throw IoError(sequence_, "its image names are no time stamps: poses cannot be matched");

    MapUpdateParams params = params_;
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

  double pose_tolerance_ = 0.02;
  bool without_poses_ = false;
  MapUpdateParams params_;  // but for those of trajectory and views
  ImageTrajectory by_images_;
};

/** facetloc_map changes: surfaces that a later session finds gone or new. */
class MapChangesApp : public MapSessionApp {
public:
  MapChangesApp()
      : MapSessionApp(
            "facetloc_map changes", "MAP.flmap RECORDING [--csv OUT.csv] [--page OUT.html] [options]",
            "Lists the surfaces of a map that a later session looks through, and the new ones where "
            "the map looks through, with their areas and probabilities. The map is not changed.") {}

private:
  void addOptions(CommandLine& line) override {
    addSessionOptions(line);
    line.addOption("csv", csv_, "OUT.csv", "Write all changed surfaces, with their outlines.");
    line.addOption("page", page_, "OUT.html", "Write a page for browsers: the map with what has changed.");
    line.addExample("office.flmap later", "what was moved since the map was made");
    line.addExample("office.flmap later --page changes.html", "to look at in a browser");
  }

  int execute(const CommandLine& line, const Console& console) override {
    const auto map = readMapWithPoses(console);
    const DepthSequence sequence = openSequence(sequence_, input_.recording, console);
    const MapSession session = find(map, sequence, line, console);
    const std::vector<SurfaceChange> changes = session.changes();
    printSurfaces(console.out, *map, changes);
    if (!csv_.empty()) writeSurfaces(csv_, *map, changes);
    if (!page_.empty()) {
      MapPage page;
      page.title = fmt::format("Changes of {} by {}", fs::path(map_).stem().string(), sequence_);
      page.changes = changes;
      page.runs = {{"session", {}}};
      for (const TrajectoryPose& pose : session.poses()) page.runs.front().T_w_c.push_back(pose.T_w_c);
      writeMapPage(page_, *map, page);
    }
    return code_;
  }

  std::string csv_, page_;
};

/** facetloc_map extend: a later session brings a map up to date. */
class MapExtendApp : public MapSessionApp {
public:
  MapExtendApp()
      : MapSessionApp(
            "facetloc_map extend", "MAP.flmap RECORDING [-o NEW.flmap] [options]",
            "Updates a map with a later session. Finds the session in the map, removes surfaces that its "
            "images look through, replaces local models that have lost much, and adds new places. The "
            "trajectory comes from the RECORDING's poses or from --poses, in any coordinates, or else from "
            "the images. If the session is not found in the map, the map is not changed.") {}

private:
  void addOptions(CommandLine& line) override {
    addSessionOptions(line);
    line.addOption("output,o", output_, "NEW.flmap", "The map to write; MAP.flmap itself unless given.");
    line.addOption("trajectory", trajectory_, "OUT.txt",
                   "Write the poses of the session in the map, in the TUM format.");
    line.addSwitch("overwrite", overwrite_, "Replace an existing NEW.flmap.");
    line.addExample("office.flmap later", "the map itself, as a whole");
    line.addExample("office.flmap later -o newer.flmap", "a new map");
  }

  void writeTrajectory(const MapSession& session) const {
    std::vector<StampedPose> poses;
    for (const TrajectoryPose& pose : session.poses()) poses.push_back({pose.stamp, pose.T_w_c});
    writeTumTrajectory(trajectory_, poses);
  }

  int execute(const CommandLine& line, const Console& console) override {
    const auto [target, lock] = lockSuccessor(map_, output_, overwrite_);
    const auto map = readMapWithPoses(console);
    const DepthSequence sequence = openSequence(sequence_, input_.recording, console);
    const MapSession session = find(map, sequence, line, console);
    Map changed = *map;
    const MapChanges changes = session.update(changed);
    printSurfaces(console.out, *map, session.changes());
    printChanges(console.out, changes);
    noteSession(fmt::format("{}: {}, {}; {}", sequence_, counted(sequence.frames().size(), "image"),
                            changes.toString(), versionText()),
                changed);
    replaceWholeMap(target, changed, threads(), console);
    if (!trajectory_.empty()) writeTrajectory(session);
    console.out << changes.toString() << "; map of " << counted(changed.models.size(), "local model")
                << " in " << target << "\n";
    return code_;
  }

  std::string output_, trajectory_;
  bool overwrite_ = false;
};

}  // namespace

std::unique_ptr<App> mapChangesApp() { return std::make_unique<MapChangesApp>(); }
std::unique_ptr<App> mapExtendApp() { return std::make_unique<MapExtendApp>(); }

}  // namespace facetloc
