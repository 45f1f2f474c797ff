// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "batch/map_watch.h"
#include "cli/text.h"
#include "cli/tools.h"
#include "inputs/depth_input.h"
#include "outputs/map_completion.h"
#include "outputs/output_folder.h"
#include "outputs/provenance.h"

#include <facetloc/features/map_metadata.h>
#include <facetloc/features/map_parts.h>
#include <facetloc/io/atomic_file.h>
#include <facetloc/io/cloud_file.h>
#include <facetloc/io/error.h>
#include <facetloc/io/map_database.h>
#include <facetloc/io/occupancy_grid_file.h>
#include <facetloc/mapping/floor_plan.h>
#include <facetloc/mapping/map_session.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fmt/core.h>
#include <iterator>
#include <map>
#include <memory>
#include <sstream>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

std::string meanMinMax(const std::vector<double>& values, int decimals) {
  if (values.empty()) return "-";
  double sum = 0;
  for (const double v : values) sum += v;
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  return fmt::format("{0:.{3}f} ({1:.{3}f} to {2:.{3}f})", sum / static_cast<double>(values.size()), *least,
                     *most, decimals);
}

std::string extentOf(const Map& map) {
  Eigen::AlignedBox3d box;
  const int part = mainPart(map);
  for (const LocalModel& model : map.models)
    if (model.T_w_m && model.part == part) box.extend(model.T_w_m->translation());
  if (box.isEmpty()) return "unknown: no model has a pose";
  const Eigen::Vector3d size = box.sizes(), from = box.min().array() + 0.0;  // -0 becomes 0
  return fmt::format("{:.2f} x {:.2f} x {:.2f} m, from ({:.2f}, {:.2f}, {:.2f})", size.x(), size.y(),
                     size.z(), from.x(), from.y(), from.z());
}

std::string cameraOf(const Map& map) {
  if (map.models.empty()) return "-";
  const Intrinsics k = map.view(0)->intrinsics;
  return fmt::format("{}x{}, fx {:.2f}, fy {:.2f}, cx {:.2f}, cy {:.2f}", k.width, k.height, k.fx, k.fy, k.cx,
                     k.cy);
}

/** The camera's, and the images' where they are noisier. \param of_images one each */
std::string noiseOf(const Map& map, const std::vector<double>& of_images) {
  std::string words = fmt::format("{:.3g} 1/m", map.camera.noise.ofInverseDepth(DepthNoise::kUsualDepth));
  if (!map.camera.noise.isConstantInInverseDepth())
    words += fmt::format(" at {:.0f} m", DepthNoise::kUsualDepth);
  const auto [least, most] = std::minmax_element(of_images.begin(), of_images.end());
  if (!of_images.empty()) words += fmt::format(", of the images {:.3g} to {:.3g}", *least, *most);
  return words;
}

std::string ambiguityOf(const Map& map) {
  if (!map.ambiguity) return "unknown";
  return fmt::format("{} nats, in the tenth of {} that looks most like another place",
                     text::decimals(map.ambiguity->score, 1),
                     counted(static_cast<std::size_t>(map.ambiguity->views), "view"));
}

std::string sureOf(const Map& map) {
  const auto threshold = sureThresholdOf(map);
  return threshold ? threshold->toString()
                   : fmt::format("p >= {}, not calibrated", text::shortest(minProbabilityOf(map)));
}

std::string partName(const std::string& name) { return name.empty() ? "the world" : name; }

/** Empty if all poses were given. */
std::string placedByLinks(const Map& map) {
  std::size_t models = 0, parts = 0;
  for (const PartCount& part : partCounts(map)) {
    models += part.by_links;
    parts += part.by_links > 0;
  }
  return models == 0 ? "" : fmt::format("{}, in {}", models, counted(parts, "part"));
}

/** Adds the parts of a map that is not all in one world. */
void addParts(TextTable& table, const Map& map) {
  constexpr std::size_t kMost = 10;  // that are listed
  if (map.parts.size() < 2) return;
  table.add({"parts", std::to_string(map.parts.size())});
  const std::vector<PartCount> counts = partCounts(map);
  for (std::size_t i = 0; i < std::min(kMost, counts.size()); ++i)
    table.add({"  " + partName(map.parts[i]), counted(counts[i].models, "local model")});
  if (counts.size() > kMost) table.add({"  and", fmt::format("{} more", counts.size() - kMost)});
}

void printSummary(std::ostream& out, const Map& map) {
  std::vector<double> segments, areas, noise;
  std::size_t with_pose = 0, with_depth = 0;
  for (std::size_t i = 0; i < map.models.size(); ++i) {
    const auto view = map.view(static_cast<int>(i));  // a large map loads its views one at a time
    segments.push_back(static_cast<double>(view->segments.size()));
    with_pose += map.models[i].givenPose().has_value();
    with_depth += view->hasPicture();
    noise.push_back(view->noise());
    for (const Segment& s : view->segments) areas.push_back(s.area());
  }
  TextTable table({"local models", ""});
  table.setWordsLast();
  table.add({"  number", std::to_string(map.models.size())});
  table.add({"  with a pose", std::to_string(with_pose)});
  if (const std::string words = placedByLinks(map); !words.empty()) table.add({"  placed by links", words});
  table.add({"  with a depth picture", std::to_string(with_depth)});
  const std::vector<char> rendered = renderedViews(map);
  if (const auto n = std::count(rendered.begin(), rendered.end(), 1); n > 0)
    table.add({"  rendered beside the drive", std::to_string(n)});
  table.add({"  extent of their poses", extentOf(map)});
  table.add({"  working camera", cameraOf(map)});
  table.add({"links", std::to_string(map.links.size())});
  addParts(table, map);
  table.add({"segments", std::to_string(areas.size())});
  table.add({"  per model", meanMinMax(segments, 1)});
  table.add({"  area of the hull [m2]", meanMinMax(areas, 3)});
  table.add({"camera mounting", map.camera.mounting ? toString(*map.camera.mounting) : "unknown"});
  table.add({"noise of inverse depth", noiseOf(map, noise)});
  table.add({"errors that views share", consideredErrorsOf(map).toString()});
  table.add({"wrong places score", ambiguityOf(map)});
  table.add({"sure from", sureOf(map)});
  table.add({"distortion taken out",  // a Kinect's unit is the one that people know
             map.camera.distortion ? fmt::format("{:.2f} disparity units (1/8 px of a Kinect) on average",
                                                 kKinectGain * map.camera.distortion->rms())
                                   : "none"});
  out << table;
}

using Views = std::vector<OwnView>;

template <class Chosen>
Views only(const Views& views, const Chosen& chosen) {
  Views some;
  std::copy_if(views.begin(), views.end(), std::back_inserter(some), chosen);
  return some;
}

/** The most frequent free motions of one part of a map; empty without any. */
std::string weakDirection(const Views& views) {
  std::map<std::string, int> counts;
  for (const OwnView& view : views)
    if (!view.free_motions.empty()) ++counts[view.free_motions];
  const auto most = std::max_element(counts.begin(), counts.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == counts.end() ? "" : fmt::format("{} leave free {}", most->second, most->first);
}

void addRow(const std::string& name, const Views& views, const std::string& weak, TextTable& table) {
  const auto number = [&](const auto& chosen) { return std::to_string(only(views, chosen).size()); };
  table.add({name, std::to_string(views.size()), number([](const OwnView& v) { return v.right; }),
             number([](const OwnView& v) { return v.state == AnswerState::sure; }),
             number([](const OwnView& v) { return v.isSureAndRight(); }),
             number([](const OwnView& v) { return v.isInside(); }),
             number([](const OwnView& v) { return v.isAlias(); }), weak});
}

/** Names the region with most images that are not sure and right, weighed by their share of its images. */
std::string adviceOn(const Map& map, const Views& views) {
  constexpr double kRadius = 2;  // [m]
  const auto fails = [](const OwnView& view) { return !view.isSureAndRight(); };
  double most = 0;
  std::string advice = "every image is sure and right without itself";
  for (const OwnView& centre : only(views, fails)) {
    const LocalModel& model = map.models[centre.model];
    const Eigen::Vector3d at = model.T_w_m->translation();
    const Views region = only(views, [&](const OwnView& view) {
      const LocalModel& other = map.models[view.model];
      return other.part == model.part && (other.T_w_m->translation() - at).norm() <= kRadius;
    });
    const std::size_t failed = only(region, fails).size();
    const double weight = static_cast<double>(failed * failed) / static_cast<double>(region.size());
    if (weight <= most) continue;
    most = weight;
    advice = fmt::format(
        "record more around image {} at ({:.2f}, {:.2f}, {:.2f}) in {}: {} of {} within {:.0f} m are not "
        "sure and right",
        model.name, at.x(), at.y(), at.z(), partName(map.partOf(centre.model)), failed,
        counted(region.size(), "image"), kRadius);
    if (const std::string weak = weakDirection(region); !weak.empty()) advice += "; " + weak;
  }
  return advice;
}

/** The map's own images, each localized without itself, by its parts and in all, and where more of them are
 * needed most. */
void printOwnViews(std::ostream& out, const Map& map, const Views& views) {
  constexpr std::size_t kEnough = 10;  // images that advice takes
  TextTable table({"own images, each without itself", "images", "rank 1 right", "sure", "sure and right",
                   "inside 95 %", "aliases", "weak directions"});
  table.setWordsLast();
  const int parts = std::max(1, static_cast<int>(map.parts.size()));
  for (int part = 0; part < parts; ++part) {
    const Views here = only(views, [&](const OwnView& v) { return map.models[v.model].part == part; });
    if (!here.empty()) addRow(partName(map.partOf(here.front().model)), here, weakDirection(here), table);
  }
  addRow("all", views, "", table);
  out << table;
  if (views.size() >= kEnough) out << adviceOn(map, views) << "\n";
}

/** Values of several lines, such as parameters, are indented below their key, or only counted. */
void printMeta(std::ostream& out, const Map& map, bool all) {
  for (const auto& [key, value] : map.meta) {
    if (key == kImagesKey || key == kSureKey || key == kRenderedKey || key == kConsideredErrorsKey)
      continue;  // for programs
    const auto lines = static_cast<std::size_t>(std::count(value.begin(), value.end(), '\n'));
    if (lines == 0) {
      out << key << ": " << value << "\n";
    } else if (!all) {
      out << key << ": " << counted(lines, "line") << " (--all)\n";
    } else {
      out << key << ":\n";
      std::istringstream text(value);
      for (std::string line; std::getline(text, line);) out << "  " << line << "\n";
    }
  }
}

std::optional<DepthDistortion::Values> distortionOf(const Map& map) {
  return map.camera.distortion ? std::optional(map.camera.distortion->values()) : std::nullopt;
}

/** Tells which map's distortion mergedMap() takes, unless all have the same. */
void noteChosenDistortion(const std::vector<Map>& maps, const std::vector<std::string>& paths,
                          const Console& console) {
  const auto chosen = std::find_if(maps.begin(), maps.end(),
                                   [](const Map& map) { return map.camera.distortion.has_value(); });
  if (chosen == maps.end()) return;
  if (std::any_of(maps.begin(), maps.end(),
                  [&](const Map& map) { return distortionOf(map) != distortionOf(*chosen); }))
    console.note("the maps differ in the distortion that was taken out; the merged one has the one of " +
                 paths[chosen - maps.begin()]);
}

/** Red, green and blue as the normal has x, y and z. */
PointColour colourOf(const Eigen::Vector3d& normal) {
  const auto channel = [&normal](int axis) {
    return static_cast<std::uint8_t>(std::lround(127.5 + 127.5 * std::clamp(normal[axis], -1.0, 1.0)));
  };
  return {channel(0), channel(1), channel(2)};
}

/** Polygons of all local models of the part to show, in its frame. */
std::vector<ColouredPolygon> polygonsOf(const Map& map, const std::string& path) {
  const int part = mainPart(map);
  std::vector<ColouredPolygon> polygons;
  bool has_pose = false;
  for (std::size_t i = 0; i < map.models.size(); ++i) {
    const LocalModel& model = map.models[i];
    if (!model.T_w_m || model.part != part) continue;
    has_pose = true;
    const std::shared_ptr<const View> view = map.view(static_cast<int>(i));
    for (const Segment& segment : view->segments) {
      const Segment placed = transformed(segment, *model.T_w_m);
      polygons.push_back(polygonOf(placed, colourOf(placed.normal())));
    }
  }
  if (!has_pose) throw IoError(path, "has no pose of any local model: nothing says how its segments lie");
  return polygons;
}

/** facetloc_map info: the content of a map, for people. */
class MapInfoApp : public App {
public:
  MapInfoApp()
      : App("facetloc_map info", "MAP.flmap [--self]",
            "Prints the content of a map and how it was made, on one screen. With --self, it also localizes "
            "each image of the map in the map without that image, which shows where answers will fail.") {}

private:
  void addOptions(CommandLine& line) override {
    line.addArgument("MAP.flmap", map_);
    line.addSwitch("all", all_, "Also print the parameters it was made with.");
    line.addSwitch("self", self_,
                   "Localize the map's own images without themselves, and print how many are right and sure "
                   "in each part of the map.");
    line.addExample("office.flmap", "on one screen");
    line.addExample("office.flmap --self", "where it fails, and where to record more");
  }

  int execute(const CommandLine&, const Console& console) override {
    const auto map = std::make_shared<const Map>(openMap(map_));
    printSummary(console.out, *map);
    console.out << "\n";
    printMeta(console.out, *map, all_);
    if (self_) {
      MapWatch watch(console);
      const std::vector<OwnView> views = localizeOwnViews(map, {}, {}, threads(), watch.callback());
      console.out << "\n";
      printOwnViews(console.out, *map, views);
    }
    console.out << "\nmap: " << map_ << ", " << fs::file_size(map_) / 1024 << " KiB\n";
    return kOk;
  }

  std::string map_;
  bool all_ = false, self_ = false;
};

/** facetloc_map check: proves a map sound, or lists its faults. */
class MapCheckApp : public App {
public:
  MapCheckApp()
      : App("facetloc_map check", "MAP.flmap",
            "Checks every value in a map file. Lists all faults and exits with 1 if it is invalid.") {}

private:
  void addOptions(CommandLine& line) override {
    line.addArgument("MAP.flmap", map_);
    line.addExample("office.flmap", "valid, or a list of faults");
    line.addExample("office.flmap --quiet", "for scripts: the exit code is the result");
  }

  int execute(const CommandLine&, const Console& console) override {
    std::vector<std::string> faults = checkMap(map_);
    if (faults.empty()) faults = placeIndexFaults(map_);
    if (faults.empty()) noteUnfinished(openMap(map_), map_, console);
    for (const std::string& fault : faults) console.print(fault + "\n");
    console.print(fmt::format("{}: {}\n", map_, faults.empty() ? "sound" : counted(faults.size(), "fault")));
    return faults.empty() ? kOk : kFailed;
  }

  std::string map_;
};

/** facetloc_map export: a map for other programs. */
class MapExportApp : public App {
public:
  MapExportApp()
      : App("facetloc_map export", "MAP.flmap -o DIR | --g2o FILE | --ply FILE | --grid NAME",
            "Exports a map for other programs. DIR gets models/<name>.pcd (SegmentFrame clouds, each in its "
            "model's frame), poses_tum.txt and graph.g2o. After another program has optimized the graph, "
            "'facetloc_map import' reads its poses back.") {}

private:
  void addOptions(CommandLine& line) override {
    line.addArgument("MAP.flmap", map_);
    line.addOption("output,o", folder_, "DIR", "Folder of the exported files.");
    addOverwrite(line, overwrite_);
    line.addOption("g2o", graph_, "FILE", "Write local models and links in g2o's format.");
    line.addOption("ply", polygons_, "FILE",
                   "Write the outlines of all segments, coloured by direction. Coordinates are in the world, "
                   "or in the largest part of a map without one.");
    line.addOption("grid", grid_, "NAME",
                   "Write an occupancy grid for a 2-D robot, NAME.yaml and NAME.pgm for ROS's map_server. "
                   "Upright segments are occupied, space that the images have seen is free.");
    line.addParams(grid_params_, "grid", CommandLine::Shown::in_help);
    line.addExample("office.flmap -o exported", "clouds of segments and trajectory");
    line.addExample("office.flmap --g2o office.g2o", "for a pose graph optimizer");
  }

  void writeGrid(const Map& map, const Console& console) const try {
    const OccupancyGrid grid = gridOf(map, grid_params_);
    const fs::path path = occupancyGridPath(grid_);
    if (path.has_parent_path()) createFolders(path.parent_path());
    writeOccupancyGrid(path, grid);
    console.print(fmt::format("floor plan of {:.1f} x {:.1f} m in {}\n", grid.width * grid.resolution,
                              grid.height * grid.resolution, path.string()));
  } catch (const IoError&) {
    throw;
  } catch (const std::runtime_error& e) {
    throw IoError(map_, fmt::format("cannot be made into a floor plan: {}", e.what()));
  }

  int execute(const CommandLine&, const Console& console) override {
    if (folder_.empty() && graph_.empty() && polygons_.empty() && grid_.empty())
      throw UsageError("there is nothing to export: give -o DIR, --g2o FILE, --ply FILE or --grid NAME");
    const Map map = openMap(map_);
    if (!folder_.empty()) claimFolder(folder_, {"graph.g2o"}, overwrite_, &console);
    if (!graph_.empty()) writeGraph(graph_, map);
    if (!polygons_.empty()) writePolygons(polygons_, polygonsOf(map, map_));
    if (!grid_.empty()) writeGrid(map, console);
    if (!folder_.empty()) exportMap(map, folder_);
    console.print(fmt::format("{} exported{}{}{}\n", counted(map.models.size(), "local model"),
                              folder_.empty() ? "" : "; files in " + folder_,
                              graph_.empty() ? "" : "; graph in " + graph_,
                              polygons_.empty() ? "" : "; polygons in " + polygons_));
    return kOk;
  }

  std::string map_, folder_, graph_, polygons_, grid_;
  bool overwrite_ = false;
  MapGridParams grid_params_;
};

/** facetloc_map import: a copy of a map with the poses that another program has found. */
class MapImportApp : public App {
public:
  MapImportApp()
      : App("facetloc_map import", "MAP.flmap --g2o FILE -o OUT.flmap",
            "Copies a map with new poses of its local models from a g2o file (VERTEX_SE3:QUAT, numbered as "
            "by 'facetloc_map export --g2o'). Links are kept. Parts without a link to the world keep their "
            "own frames.") {}

private:
  void addOptions(CommandLine& line) override {
    line.addArgument("MAP.flmap", map_);
    line.addOption("g2o", graph_, "FILE", "Poses of the local models.");
    line.addOption("output,o", output_, "OUT.flmap", "The map to write.");
    line.addSwitch("overwrite", overwrite_, "Replace an existing map.");
    line.addExample("office.flmap --g2o office.g2o -o moved.flmap", "poses of another program");
    line.addExample("office.flmap --g2o office.g2o -o office.flmap --overwrite", "in its place");
  }

  int execute(const CommandLine&, const Console& console) override {
    if (graph_.empty()) throw UsageError("the file with the poses is missing: --g2o FILE");
    const Map map = writeNewMap(output_, overwrite_, threads(), console, [&] {
      Map moved = noteUnfinished(readMap(map_), map_, console);
      readGraphPoses(graph_, moved);
      return moved;
    });
    const auto posed = std::count_if(map.models.begin(), map.models.end(),
                                     [](const LocalModel& m) { return m.givenPose().has_value(); });
    console.out << counted(static_cast<std::size_t>(posed), "pose") << " of "
                << counted(map.models.size(), "local model") << "; map in " << output_ << "\n";
    return kOk;
  }

  std::string map_, graph_, output_;
  bool overwrite_ = false;
};

/** facetloc_map merge: the local models of several maps in one, in one world. */
class MapMergeApp : public App {
public:
  MapMergeApp()
      : App("facetloc_map merge", "MAP.flmap... -o OUT.flmap",
            "Merges the local models and links of several maps. Each map is aligned with the earlier ones by "
            "localizing its views in them; maps in the same world frame stay where they are. With "
            "--same-coordinates, as for the floors of a house, nothing is aligned. Names that occur more "
            "than once are prefixed by the name of their map.") {}

private:
  void addOptions(CommandLine& line) override {
    line.addArguments("MAP.flmap", maps_);
    line.addOption("output,o", output_, "OUT.flmap", "The map to write.");
    line.addSwitch("same-coordinates", same_coordinates_,
                   "Keep all poses: the maps share a world frame, even without a common place.");
    line.addSwitch("overwrite", overwrite_, "Replace an existing map.");
    line.addExample("east.flmap west.flmap -o house.flmap", "aligned by what they share");
    line.addExample("a.flmap b.flmap -o c.flmap --same-coordinates", "in one world frame");
  }

  int execute(const CommandLine&, const Console& console) override {
    const Map merged = writeNewMap(output_, overwrite_, threads(), console, [&] { return merge(console); });
    console.out << counted(merged.models.size(), "local model") << ", "
                << counted(merged.links.size(), "link") << "; map in " << output_ << "\n";
    return kOk;
  }

  /** Throws IoError for a map that is not found in those before it. */
  void align(std::vector<Map>& maps, const Console& console) const {
    MapWatch watch(console);
    const std::vector<MapAlignment> alignments = alignMaps(maps, threads(), watch.callback());
    for (std::size_t i = 0; i < alignments.size(); ++i) {
      const MapAlignment& alignment = alignments[i];
      if (alignment.tried.empty()) continue;
      if (alignment.isLost()) {
        std::string tried;
        for (const auto& [k, place] : alignment.tried)
          tried += fmt::format("; in {}, {}", maps_[k], place.toString());
        throw IoError(maps_[i],
                      fmt::format("is not found in the maps before it{}; --same-coordinates merges maps "
                                  "that share a world frame as they are",
                                  tried));
      }
      const auto& [k, place] = alignment.tried.back();
      const Eigen::Isometry3d& T = alignment.T_new_old;
      console.out << fmt::format("{} is found in {} ({}) and {}\n", maps_[i], maps_[k], place.toString(),
                                 alignment.moved
                                     ? fmt::format("moves by {:.2f} m and {:.1f} deg", T.translation().norm(),
                                                   rotationAngle(T.linear()) / kDegree)
                                     : "stays where it is");
    }
  }

  Map merge(const Console& console) const {
    std::vector<Map> maps;
    std::vector<std::string> stems;
    for (const std::string& path : maps_) {
      Map& map = maps.emplace_back(noteUnfinished(readMap(path), path, console));
      for (const char* key : {"format", "conventions", kImagesKey})
        map.meta.erase(key);  // set by the file itself
      stems.push_back(fs::path(path).stem().string());
    }
    if (!same_coordinates_) align(maps, console);
    Map merged = mergedMap(maps, stems);
    merged.meta["software"] = versionText();
    const auto hasMounting = [](const Map& map) { return map.camera.mounting.has_value(); };
    if (!merged.camera.mounting && std::any_of(maps.begin(), maps.end(), hasMounting))
      console.note("the maps differ in the camera's mounting; the merged one has none");
    noteChosenDistortion(maps, maps_, console);
    return merged;
  }

  std::vector<std::string> maps_;
  std::string output_;
  bool same_coordinates_ = false, overwrite_ = false;
};

Command commandOf(const char* name, const char* arguments, const char* what, MakeApp* make) {
  return {name, arguments, what, [make](const std::vector<std::string>& given, const Console& console) {
            return make()->run(given, console);
          }};
}

}  // namespace

const CommandProgram& mapProgram() {
  static const CommandProgram program{
      "facetloc_map",
      "Maps of planar surface segments.",
      {commandOf("build", "RECORDING -o MAP.flmap", "build a map from a recording", mapBuildApp),
       commandOf("from-model", "MODEL -o MAP.flmap", "build a map from a scan, mesh or plan of a building",
                 mapModelApp),
       commandOf("extend", "MAP.flmap RECORDING", "update a map with a later recording", mapExtendApp),
       commandOf("changes", "MAP.flmap RECORDING", "list surfaces that are gone or new in a later recording",
                 mapChangesApp),
       commandOf("densify", "MAP.flmap", "add rendered views beside the drive", mapDensifyApp),
       commandOf("calibrate", "MAP.flmap [RECORDING]", "find the minimum probability of sure answers",
                 mapCalibrateApp),
       commandOf("info", "MAP.flmap", "print the content of a map", mapInfoApp),
       commandOf("check", "MAP.flmap", "check every value in a map file", mapCheckApp),
       commandOf("export", "MAP.flmap -o DIR", "write PCD, TUM and g2o files", mapExportApp),
       commandOf("import", "MAP.flmap -o OUT.flmap", "read new poses from a g2o file", mapImportApp),
       commandOf("merge", "MAP.flmap... -o OUT.flmap", "merge several maps into one", mapMergeApp)}};
  return program;
}

std::unique_ptr<App> mapInfoApp() { return std::make_unique<MapInfoApp>(); }
std::unique_ptr<App> mapCheckApp() { return std::make_unique<MapCheckApp>(); }
std::unique_ptr<App> mapExportApp() { return std::make_unique<MapExportApp>(); }
std::unique_ptr<App> mapImportApp() { return std::make_unique<MapImportApp>(); }
std::unique_ptr<App> mapMergeApp() { return std::make_unique<MapMergeApp>(); }

}  // namespace facetloc
