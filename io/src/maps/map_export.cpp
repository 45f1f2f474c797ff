// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/io/atomic_file.h>
#include <facetloc/io/map_export.h>
#include <facetloc/io/map_graph.h>
#include <facetloc/io/segment_file.h>
#include <facetloc/io/trajectory.h>

#include <cctype>
#include <set>
#include <string>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

constexpr const char* kGraph = "graph.g2o";

/** A name that is a file name everywhere, and no other model's. */
std::string fileName(const std::string& name, std::set<std::string>& taken) {
  std::string safe = name;
  for (char& c : safe)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '.' && c != '-' && c != '_') c = '_';
  if (safe.empty() || safe.front() == '.') safe.insert(0, "_");
  while (!taken.insert(safe).second) safe += "_";
  return safe;
}

std::vector<StampedPose> posesOf(const Map& map) {
  std::vector<StampedPose> poses;
  for (const LocalModel& model : map.models)
    if (const auto T_w_m = model.givenPose()) poses.push_back({model.stamp, *T_w_m});
  return poses;
}

}  // namespace

void exportMap(const Map& map, const std::filesystem::path& folder) {
  createFolders(folder / "models");
  if (std::filesystem::exists(folder / kGraph))  // left by an earlier export
    for (const auto& entry : std::filesystem::directory_iterator(folder / "models"))
      if (entry.path().extension() == ".pcd") std::filesystem::remove(entry.path());
  std::set<std::string> taken;
  for (std::size_t i = 0; i < map.models.size(); ++i) {
    const std::string name = fileName(map.models[i].name, taken);
    const auto view = map.view(static_cast<int>(i));
    if (view->segments.empty()) continue;  // PCL writes no empty clouds
    writeSegments(folder / "models" / (name + ".pcd"), view->segments);
  }
  writeTumTrajectory(folder / "poses_tum.txt", posesOf(map));
  writeGraph(folder / kGraph, map);
}

}  // namespace facetloc
