// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "batch/map_watch.h"
#include "cli/text.h"
#include "cli/tools.h"
#include "drawing/offscreen_display.h"
#include "drawing/plan_view.h"
#include "outputs/map_completion.h"
#include "outputs/output_folder.h"

#include <facetloc/features/camera_presets.h>
#include <facetloc/features/pose.h>
#include <facetloc/io/camera_file.h>
#include <facetloc/io/cloud_file.h>
#include <facetloc/io/error.h>
#include <facetloc/io/occupancy_grid_file.h>
#include <facetloc/io/trajectory.h>
#include <facetloc/mapping/floor_plan.h>
#include <facetloc/mapping/mesh_surface.h>
#include <facetloc/mapping/model_map.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <spawn.h>
#include <stdexcept>
#include <string>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>
#include <vector>

extern char** environ;

namespace facetloc {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::pair<const char*, double>, 5> kUnits{
    {{"m", 1}, {"cm", 0.01}, {"mm", 0.001}, {"in", 0.0254}, {"ft", 0.3048}}};

/** "1,2.5,0"; nothing for other words. */
std::optional<Eigen::Vector3d> threeNumbers(const std::string& words) {
  const auto parts = text::split(words, ',');
  if (parts.size() != 3) return {};
  Eigen::Vector3d numbers;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto number = text::to<double>(text::trimmed(parts[k]));
    if (!number || !std::isfinite(*number)) return {};
    numbers[static_cast<Eigen::Index>(k)] = *number;
  }
  return numbers;
}

/** The unit in which a length of a file is nearest to a usual one [m]; null if it is far from it in all. */
const char* unitFor(double in_file, double usual) {
  constexpr double kFar = 3;  // times
  const char* best = nullptr;
  double nearest = std::log(kFar);
  for (const auto& [name, metres] : kUnits)
    if (const double off = std::abs(std::log(in_file * metres / usual)); off < nearest)
      nearest = off, best = name;
  return best;
}

Finding unitQuestion(Severity severity, const std::string& words, const char* unit, double length) {
  return {"model.units",
          severity,
          words,
          unit ? fmt::format("is its unit {0}? --units {0}", unit)
               : std::string("--units names the unit of its coordinates"),
          {{"length_m", length}}};
}

/** Metres per unit of a model: m, cm, mm, in or ft. Throws UsageError for another word. */
double metresPer(const std::string& unit) {
  for (const auto& [name, metres] : kUnits)
    if (unit == name) return metres;
  throw UsageError("units: '" + unit + "' is not one of m, cm, mm, in, ft");
}

/** "z", "-y", or three numbers; none for "auto". Throws UsageError for anything else. */
std::optional<Eigen::Vector3d> directionOf(const std::string& words) {
  if (words == "auto") return {};
  const bool negative = !words.empty() && words[0] == '-';
  const std::string axis = words.substr(negative ? 1 : 0);
  if (axis.size() == 1 && axis[0] >= 'x' && axis[0] <= 'z')
    return (negative ? -1 : 1) * Eigen::Vector3d::Unit(axis[0] - 'x');
  const auto direction = threeNumbers(words);
  if (!direction || direction->norm() == 0)
    throw UsageError("up: '" + words +
                     "' is neither an axis (x, -x, y, ...) nor a direction (0,-1,0.1) nor auto");
  return direction->normalized();
}

/** "1,2.5,0". Throws UsageError for anything else. */
Eigen::Vector3d placeOf(const std::string& words) {
  const auto place = threeNumbers(words);
  if (!place) throw UsageError("inside: '" + words + "' is not of the form x,y,z in metres");
  return *place;
}

/** A direction as directionOf() reads it. */
std::string toOption(const Eigen::Vector3d& direction) {
  constexpr double kExact = 1e-4;
  for (int k = 0; k < 3; ++k)
    if (1 - std::abs(direction[k]) < kExact * kExact / 2)
      return fmt::format("{}{}", direction[k] < 0 ? "-" : "", "xyz"[k]);
  const Eigen::Vector3d positive = direction + Eigen::Vector3d::Zero();  // no -0
  return fmt::format("{:.4f},{:.4f},{:.4f}", positive.x(), positive.y(), positive.z());
}

/** The upward directions that a model suggests, as options. */
std::string upOptions(const SurfaceOrientation& orientation) {
  if (orientation.axes.empty()) return "--up DIRECTION";
  std::vector<std::string> options;
  for (const Eigen::Vector3d& up : orientation.candidates()) options.push_back("--up=" + toOption(up));
  return fmt::format("{}", fmt::join(options, " or "));
}

/** The remark about an upward direction that the model contradicts; empty if it does not.
 * \param up a unit vector */
std::string upRemark(const SurfaceOrientation& orientation, const Eigen::Vector3d& up) {
  using Verdict = SurfaceOrientation::Verdict;
  const SurfaceOrientation::Judgement judged = orientation.judge(up);
  const double angle = std::acos(std::clamp(up.dot(judged.better), -1.0, 1.0)) / kDegree;
  switch (judged.verdict) {
  case Verdict::inclined:
    return fmt::format("its floor is inclined by {:.1f} deg: --up={} levels it", angle,
                       toOption(judged.better));
  case Verdict::upside_down:
    return fmt::format(
        "it is upside down, by the ceilings that it lacks or by what stands on its floors: --up={}",
        toOption(judged.better));
  case Verdict::other_axis:
    return fmt::format(
        "its floors do not face {}, which is up unless --up says otherwise; its largest planes suggest {}",
        toOption(up), upOptions(orientation));
  case Verdict::plausible:
    break;
  }
  return {};
}

/** The finding about a unit that gives rooms unusual heights, a refusal if no building has such; empty
 * if it does not. \param unit in which the model was read \param bounds of it [m] */
std::optional<Finding> unitFinding(const std::string& unit, const SurfaceOrientation& orientation,
                                   const Eigen::AlignedBox3d& bounds, const Eigen::Vector3d& up) {
  constexpr double kLowest = 1, kHighest = 20, kUsual = 2.7;  // height of rooms [m]
  constexpr double kNoRoom = 50;                           // no room is higher, but those of a few domes [m]
  constexpr double kSmallest = 0.5, kUsualExtent = 10;     // extents of a model [m]
  constexpr double kHighestOpen = 50, kNoBuilding = 1000;  // heights of a model without a whole room [m]
  if (bounds.isEmpty()) return {};
  const Eigen::Vector3d size = bounds.sizes();
  if (size.maxCoeff() < kSmallest)
    return unitQuestion(
        Severity::refusal,
        fmt::format("it is only {:.3g} x {:.3g} x {:.3g} m large", size.x(), size.y(), size.z()),
        unitFor(size.maxCoeff() / metresPer(unit), kUsualExtent), size.maxCoeff());
  const double rooms = orientation.judge(up).clear_height, whole = up.cwiseAbs().dot(size);
  const bool is_usual = rooms > 0 ? rooms >= kLowest && rooms <= kHighest : whole <= kHighestOpen;
  if (is_usual) return {};
  const double height = rooms > 0 ? rooms : whole;
  return unitQuestion(
      height > (rooms > 0 ? kNoRoom : kNoBuilding) ? Severity::refusal : Severity::doubt,
      fmt::format("{} {:.{}f} m high", rooms > 0 ? "its rooms are" : "it is", height, height < 10 ? 2 : 0),
      unitFor(height / metresPer(unit), kUsual), height);
}

/** The finding about more places for a camera than are looked from. \param spacing of views [m]
 * \param is_plan whether the model is a floor plan, which has no unit to name */
Finding sizeFinding(std::size_t places, double spacing, bool is_plan) {
  constexpr double kLargest = 10;  // spacing that can be asked for [m]
  constexpr auto kMost = static_cast<double>(ModelMap::kMostPlaces);
  const auto n = static_cast<double>(places);
  const double wider = std::ceil(2 * spacing * std::sqrt(1.05 * n / kMost)) / 2;  // places of two dimensions
  const std::string cure = is_plan ? std::string("look at the resolution in its YAML file")
                                   : std::string("is its unit right? --units names it");
  return {
      "model.size",
      Severity::refusal,
      fmt::format("a camera can be at about {} places in it, more than {}", places, ModelMap::kMostPlaces),
      cure + (wider <= kLargest ? fmt::format(", or take fewer: --spacing {}", wider) : std::string()),
      {{"places", n}}};
}

std::vector<Eigen::Isometry3d> posesIn(const std::string& path, const Console& console) {
  std::string remark;
  std::vector<Eigen::Isometry3d> poses = posesOf(readTrajectory(path, &remark));
  console.note(remark);
  if (poses.empty()) throw IoError(path, "has no poses");
  return poses;
}

/** A tool beside this program, or else of the PATH; nothing if it is not installed. */
std::optional<fs::path> findTool(const std::string& name) {
  std::error_code ignored;
  std::vector<fs::path> folders = {fs::read_symlink("/proc/self/exe", ignored).parent_path()};
  if (const char* path = std::getenv("PATH"))
    for (const std::string_view folder : text::split(path, ':')) folders.emplace_back(folder);
  for (const fs::path& folder : folders)
    if (!folder.empty() && access((folder / name).c_str(), X_OK) == 0) return folder / name;
  return {};
}

/** Runs a program to its end, with the same output streams. \return whether its exit code is 0 */
bool succeeds(const fs::path& program, const std::vector<std::string>& arguments) {
  std::vector<std::string> copies = {program.filename().string()};
  copies.insert(copies.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& copy : copies) argv.push_back(copy.data());
  argv.push_back(nullptr);
  pid_t child = 0;
  int status = 0;
  if (posix_spawn(&child, program.c_str(), nullptr, nullptr, argv.data(), environ) != 0) return false;
  return waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/** facetloc_render, which draws the picture, as only that tool needs VTK. Throws UsageError for a file that
 * is no picture, IoError if the tool is not installed. */
fs::path rendererOf(const fs::path& picture) {
  requireReplaceable(picture);
  if (!FACETLOC_WITH_VTK) throw IoError(picture.string(), std::string("cannot be drawn: ") + kWithoutVtk);
  const auto renderer = findTool("facetloc_render");
  if (!renderer)
    throw IoError(
        picture.string(),
        "cannot be drawn: facetloc_render is not installed, which is in the package facetloc-tools-gui");
  return *renderer;
}

/** facetloc_map from-model: a scan or mesh of a building -> a map. */
class MapModelApp : public App {
public:
  MapModelApp()
      : App("facetloc_map from-model", "MODEL -o MAP.flmap [options]",
            "Builds a map from a scan, mesh or plan of a building. MODEL is a .ply, .obj or .stl mesh, a "
            ".ply or .pcd cloud, or the map.yaml of an occupancy grid, whose walls are extruded. Depth "
            "images are rendered where a camera can be, and become local models. The world of the map is the "
            "frame of the MODEL, in metres.") {}

private:
  void addOptions(CommandLine& line) override {
    line.addArgument("MODEL", model_);
    line.addOption("output,o", map_, "MAP.flmap", "The map to write.");
    line.addOption(
        "camera", camera_, "FILE|NAME",
        fmt::format("Camera to be localized later: a camera.ini, a map made with it, or a preset: {}.",
                    cameraPresetNames()));
    line.addOption(
        "viewpoints", viewpoints_, "FILE",
        "Camera poses in the MODEL [m], one for each local model; found automatically unless given.");
    line.addOption("height", height_, "M",
                   "Height of the camera above the floor [m]; 0 = as mounted, or hand-held.");
    line.addOption("units", units_, "UNIT",
                   "Unit of the MODEL's coordinates: m, cm, mm, in or ft; m unless given.");
    line.addOption(
        "up", up_, "AXIS",
        "Upward direction in the MODEL: x, y, z, --up=-x, ..., a vector x,y,z, or auto, found in the "
        "MODEL; z unless given.");
    line.addOption("inside", inside_, "X,Y,Z",
                   "A place in the area to fill [m]; all but the one around all others unless given.");
    line.addOption("wall-height", floor_plan_.wall_height, "M",
                   "Height of the walls of an occupancy grid [m], which does not state it.");
    line.addSwitch("ceiling", floor_plan_.ceiling,
                   "Add a ceiling to an occupancy grid, as high as its walls.");
    line.addOption("plan", plan_, "OUT.png", "Draw the floor map with the viewpoints, by facetloc_render.");
    line.addOption("width", width_, "N", "Minimum width of the rendered images [px]; 0 = 320.");
    line.addCheck([this, &line] {
      metresPer(units_);
      directionOf(up_);
      if (!inside_.empty()) placeOf(inside_);
      if (!(height_ >= 0 && height_ < 100)) throw UsageError("height must be from 0 to 100 m");
      if (width_ < 0 || width_ > 10000) throw UsageError("width must be from 0 to 10000");
      for (const char* option : {"height", "up", "inside"})
        if (!viewpoints_.empty() && line.given(option))
          throw UsageError(std::string(option) +
                           " is for places that are looked for, and viewpoints names them");
      checkFloorPlan(line);
    });
    line.addSwitch("overwrite", overwrite_, "Replace an existing map.");
    line.addSwitch("force", force_, "Build the map even if the MODEL's size is doubtful or takes hours.");
    line.addParams(params_, "", CommandLine::Shown::in_help);
    line.addParams(view_);
    line.addExample("scan.ply -o house.flmap --camera kinect", "a scan, in metres, z up");
    line.addExample("map.yaml -o plan.flmap --wall-height 2.5", "an occupancy grid");
  }

  bool isFloorPlan() const {
    const fs::path extension = fs::path(model_).extension();
    return extension == ".yaml" || extension == ".yml";
  }

  void checkFloorPlan(const CommandLine& line) const {
    if (!isFloorPlan()) {
      if (line.given("wall-height") || floor_plan_.ceiling)
        throw UsageError("wall-height and ceiling are for the map.yaml of an occupancy grid");
      return;
    }
    if (line.given("units") || line.given("up"))
      throw UsageError("an occupancy grid is in metres, with z up: units and up are for other models");
    checkRanges(floor_plan_);
  }

  std::shared_ptr<const FloorPlanSurface> floorPlan(const Console& console) const try {
    Findings findings;
    OccupancyGrid plan = readOccupancyGrid(model_, &findings);
    for (const Finding& finding : findings) console.find(finding);
    auto surface = std::make_shared<const FloorPlanSurface>(std::move(plan), floor_plan_);
    const Eigen::Vector3d size = surface->bounds().sizes();
    console.out << fmt::format("walls on {:.2f} x {:.2f} m, {:.2f} m high\n", size.x(), size.y(), size.z());
    return surface;
  } catch (const std::invalid_argument& e) {
    throw IoError(model_, fmt::format("cannot be made into walls: {}", e.what()));
  }

  std::shared_ptr<const Surface> surface(const Console& console) const try {
    const pcl::PolygonMesh model = readModel(model_, metresPer(units_));
    const auto tell = [&console](const auto& surface, const std::string& item, std::size_t used,
                                 const char* why) {
      const Eigen::Vector3d size = surface->bounds().sizes();
      console.out << fmt::format("{} of {:.2f} x {:.2f} x {:.2f} m\n", counted(used, item), size.x(),
                                 size.y(), size.z());
      if (surface->leftOut() > 0)
        console.find({"model.left_out",
                      Severity::note,
                      fmt::format("{} left out: {}", counted(surface->leftOut(), item), why),
                      "",
                      {{"left_out", static_cast<double>(surface->leftOut())}}});
      return surface;
    };
    if (!model.polygons.empty()) {
      const auto mesh = std::make_shared<const MeshSurface>(model);
      return tell(mesh, "triangle", mesh->triangles(),
                  "without an area, not finite, or with vertices that are not there");
    }
    const auto cloud = std::make_shared<const CloudSurface>(model.cloud, threads());
    tell(cloud, "point", cloud->points(), "not finite, or far from all others");
    console.out << fmt::format(
        "points are {:.1f} mm apart and {:.1f} mm from the planes of their neighbours\n",
        1e3 * cloud->spacing(), 1e3 * cloud->residual());
    return cloud;
  } catch (const std::invalid_argument& e) {
    throw IoError(model_, e.what());
  }

  ModelMap making(const Console& console) const {
    const Camera camera = camera_.empty() ? Camera{} : cameraNamed(camera_);
    ModelMapParams params = params_;
    std::shared_ptr<const Surface> surface;
    if (isFloorPlan()) {
      const auto plan = floorPlan(console);
      params.surface_std = std::hypot(params.surface_std, plan->wallStd());
      surface = plan;
    } else {
      surface = this->surface(console);
    }
    ModelMap making(surface, camera, params, view_);
    making.setNumberOfThreads(threads());
    making.setUsualUp(Eigen::Vector3d::Unit(text::lowerExtension(model_) == ".obj" ? 1 : 2));  // y, else z
    if (const auto up = directionOf(up_))
      making.setUp(*up);
    else
      making.setUpBySurface();
    if (width_ > 0) making.setWorkingWidth(width_);
    if (force_) making.setMostPlaces(0);
    if (!inside_.empty()) making.setInside({placeOf(inside_)});
    if (height_ > 0) making.setHeights({height_});
    if (!viewpoints_.empty()) making.setViewpoints(posesIn(viewpoints_, console));
    if (!isFloorPlan()) noteOrientation(making.orientation(), surface->bounds(), console);
    return making;
  }

  std::string parameters(const Camera& camera, const ModelFindings& found) const {
    return fmt::format(
               "camera = {}\nviewpoints = {}\nheight = {}\nunits = {}\nup = {}\ninside = {}\nwidth = {}\n",
               camera_, viewpoints_, height_, units_, toOption(found.up), inside_, width_) +
           (isFloorPlan() ? toIni(floor_plan_, "floor_plan") : std::string()) + toIni(camera.noise, "noise") +
           toIni(params_) + toIni(view_);
  }

  /** Shows a finding. Throws IoError if no map is to be made. */
  void judge(const Finding& finding, const std::string& despite, const Console& console) const {
    if (finding.severity != Severity::refusal) return console.find(finding);
    console.keep(finding);
    throw IoError(model_, fmt::format("cannot be right as it is read: {}; {} the map nevertheless",
                                      finding.text(), despite));
  }

  /** Contradictions between the model and the options it was read with, before the long work. */
  void noteOrientation(const SurfaceOrientation& orientation, const Eigen::AlignedBox3d& bounds,
                       const Console& console) const {
    const std::optional<Eigen::Vector3d> named = viewpoints_.empty() ? directionOf(up_) : std::nullopt;
    const std::optional<Eigen::Vector3d> up = named ? named : orientation.up();
    if (auto finding = unitFinding(units_, orientation, bounds, up.value_or(Eigen::Vector3d::UnitZ()))) {
      if (force_ || is_unit_named_) finding->severity = Severity::doubt;
      judge(*finding, fmt::format("--units {} or --force builds", units_), console);
    }
    if (!viewpoints_.empty()) return;
    if (!named && !up)
      throw IoError(model_,
                    "its planes do not show which direction is up; name it: " + upOptions(orientation));
    if (!named) console.out << fmt::format("the upward direction is {}\n", toOption(*up));
    if (!named && !orientation.isSignKnown())
      console.find(
          {"model.up", Severity::note,
           fmt::format("nothing in it distinguishes its floors from its ceilings: if {} is down, name "
                       "the upward direction with --up={}",
                       toOption(*up), toOption(-*up)),
           ""});
    if (const std::string remark = named ? upRemark(orientation, *named) : std::string(); !remark.empty())
      console.find({"model.up", Severity::doubt, remark, ""});
  }

  Map make(const Console& console) const {
    ModelMap making = this->making(console);
    MapWatch watch(console);
    making.setProgress(watch.callback());
    Map map = making.finish();
    const ModelFindings& found = making.findings();
    if (found.too_many)
      judge(sizeFinding(found.places, params_.spacing, isFloorPlan()), "--force builds", console);
    if (map.models.empty()) throw IoError(model_, "cannot be made into a map: " + found.problem);
    if (found.places > 0)
      console.out << fmt::format("{} where the camera can be\n", counted(found.places, "place"));
    if (found.is_open)
      console.find({"model.open", Severity::note,
                    "it is no whole room: views are taken wherever they show enough of it",
                    "--viewpoints, such as the poses of the scanner, name better ones, and --up the upward "
                    "direction"});
    if (found.outdoors > 0)
      console.find({"model.outdoors",
                    Severity::note,
                    fmt::format("{} left out, in areas that {}", counted(found.outdoors, "place"),
                                inside_.empty() ? "surround all others and are taken for outdoors"
                                                : "do not hold the place that --inside names"),
                    inside_.empty() ? "--inside names an area to fill" : "",
                    {{"places", static_cast<double>(found.outdoors)}}});
    if (found.places > 0 && found.overlap < params_.overlap)
      console.note(
          fmt::format("a local model shows {:.0f} %, not {:.0f} %, of what a camera near it sees: more would "
                      "be more than {} local models",
                      100 * found.overlap, 100 * params_.overlap, params_.most_models));
    if (found.without_segments > 0)
      console.note(counted(found.without_segments, "view") + " without segments left out");
    map.meta["software"] = versionText();
    map.meta["source"] = model_;
    map.meta["made of"] = isFloorPlan() ? "a floor plan" : "a model";
    map.meta["parameters"] = parameters(map.camera, found);
    return map;
  }

  void drawPlan(const fs::path& renderer) const {
    std::vector<std::string> arguments = {map_, "-o", plan_, "--quiet"};
    if (isFloorPlan()) arguments.insert(arguments.end(), {"--grid", model_});
    if (!succeeds(renderer, arguments))
      throw IoError(plan_, "is not drawn by " + renderer.string() + "; the map is in " + map_);
  }

  int execute(const CommandLine& line, const Console& console) override {
    is_unit_named_ = line.given("units");
    const fs::path renderer = plan_.empty() ? fs::path() : rendererOf(plan_);
    const Map map = writeNewMap(map_, overwrite_, threads(), console, [&] { return make(console); });
    if (!plan_.empty()) drawPlan(renderer);
    console.out << counted(map.models.size(), "local model") << "; map in " << map_ << "\n";
    return kOk;
  }

  std::string model_, map_, camera_, viewpoints_, inside_, plan_, units_ = "m", up_ = "z";
  double height_ = 0;
  int width_ = 0;
  bool overwrite_ = false, force_ = false, is_unit_named_ = false;
  FloorPlanParams floor_plan_;
  ModelMapParams params_;
  ViewParams view_;
};

}  // namespace

std::unique_ptr<App> mapModelApp() { return std::make_unique<MapModelApp>(); }

}  // namespace facetloc
