// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "../apps/example_scene.h"
#include "fuzz_file.h"
#include "outputs/map_completion.h"

#include <facetloc/io/error.h>
#include <facetloc/io/map_database.h>
#include <facetloc/localization/place_index.h>
#include <facetloc/segmentation/view_builder.h>

#include <sqlite3.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>

namespace facetloc::fuzz {

/** \brief Three views of a corner of a room, as a camera sees them; something in each table of its file. */
inline Map smallMap() {
  Map map;
  map.camera.mounting = CameraMounting{1.0, 8};
  map.camera.distortion = DepthDistortion(DepthDistortion::extentOf(kinectIntrinsics()));
  ViewBuilder builder{Camera()};
  for (const double heading_deg : {0., 8., -20.}) {
    const std::string name = std::to_string(map.models.size());
    const Eigen::Isometry3d T_w_m = test::ExampleScene::pose(0.01 * heading_deg, 0.1, heading_deg);
    View view = builder.build(subsampled(test::ExampleScene().see(name, T_w_m).depth, 2));
    view.camera = nullptr;
    map.models.emplace_back(name, static_cast<double>(map.models.size()), T_w_m, std::move(view));
  }
  for (int i = 0; i < 2; ++i) {
    Link link;
    link.from = i, link.to = i + 1;
    link.T_from_to.P = 1e-4 * Matrix6d::Identity();
    map.links.push_back(link);
  }
  return map;
}

inline std::string indexOf(const Map& map) {
  std::ostringstream out;
  PlaceIndex(map).write(out);
  return out.str();
}

/** \brief The file of that map, with its place index; of small pages, of which most bytes mean something. */
inline std::string smallMapFile() {
  const Folder folder;
  const auto path = folder.path() / "small.flmap";
  const Map map = smallMap();
  writeMap(path, map);
  MapDatabase::open(path).setPlaceIndex([&](std::ostream& out) { out << indexOf(map); });
  sqlite3* db = nullptr;
  require(sqlite3_open(path.c_str(), &db) == SQLITE_OK &&
              sqlite3_exec(db, "PRAGMA page_size = 512; VACUUM", nullptr, nullptr, nullptr) == SQLITE_OK,
          "the example of a map cannot be made");
  sqlite3_close(db);
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/** \brief Does everything with a map file that a program does which did not write it. One that has no faults
 * may not be refused by anything. */
inline void useMap(const std::filesystem::path& path) {
  bool sound = false;
  accepts<IoError>([&] { sound = checkMap(path).empty() && placeIndexFaults(path).empty(); });
  const auto use = [&path] {
    readMap(path);
    const Map map = openMap(path, 0);  // its views are in the file
    std::shared_ptr<const View> last;
    for (std::size_t i = 0; i < map.models.size(); ++i) last = map.view(static_cast<int>(i));
    if (!map.camera.mounting || !last) return;
    PlaceIndex::of(map);
    PlaceIndex(map).candidates(*last, 10);
  };
  if (sound)
    use();
  else
    accepts<std::runtime_error>(use);
}

}  // namespace facetloc::fuzz
