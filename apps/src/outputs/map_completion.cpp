// SPDX-License-Identifier: BSD-3-Clause
#include "outputs/map_completion.h"

#include "batch/map_watch.h"

#include <facetloc/io/error.h>
#include <facetloc/io/map_database.h>
#include <facetloc/io/output_lock.h>
#include <facetloc/localization/place_index.h>
#include <facetloc/mapping/map_making.h>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

bool hasItsIndex(const Map& map) {
  const auto written = map.store() ? map.store()->placeIndex() : nullptr;
  return written && PlaceIndex::read(*written, map);
}

void completePlaceIndex(const fs::path& path) {
  const Map map = openMap(path);
  if (!map.camera.mounting || hasItsIndex(map)) return;
  if (const auto index = placeIndexOf(map)) MapDatabase::open(path).setPlaceIndex(index);
}

void completeAmbiguity(const fs::path& path, int threads, const Console& console) {
  const auto map = std::make_shared<const Map>(openMap(path));
  if (map->ambiguity) return;
  MapWatch watch(console);
  const MapAliases found = findAliases(map, threads, watch.callback());
  if (found.ambiguity) MapDatabase::open(path).setAmbiguity(*found.ambiguity, found.scores);
}

}  // namespace

void completeMounting(const fs::path& path, const Console& console) {
  const Map map = openMap(path);
  if (map.camera.mounting) return;
  const auto found = findMounting(map);
  if (!found) return;
  Camera camera = map.camera;
  camera.mounting = found->mounting;
  MapDatabase::open(path).setCamera(camera);
  console.out << "the camera is mounted " << found->toString() << "\n";
}

void completeMap(const fs::path& path, int threads, const Console& console) {
  completePlaceIndex(path);
  completeAmbiguity(path, threads, console);
}

void replaceWholeMap(const fs::path& path, const Map& map, int threads, const Console& console) {
  replaceMap(path, [&](const fs::path& temporary) {
    writeMap(temporary, map);
    completeMap(temporary, threads, console);
  });
}

OutputLock lockTarget(const fs::path& map, bool may_replace) {
  OutputLock lock = OutputLock::ofFile(map);
  if (!may_replace && fs::file_size(map) > 0)
    throw IoError(map.string(), "exists already; give --overwrite to replace it");
  return lock;
}

void writeNewMap(const std::string& path, bool overwrite, int threads, const Console& console,
                 const std::function<const Map&()>& make) {
  if (path.empty()) throw UsageError("the map to write is missing: -o OUT.flmap");
  const OutputLock lock = lockTarget(path, overwrite);
  writeMap(path, make());
  completeMap(path, threads, console);
}

std::vector<std::string> placeIndexFaults(const fs::path& path) try {
  const Map map = openMap(path, 0);
  const auto written = map.camera.mounting ? map.store()->placeIndex() : nullptr;
  if (written) PlaceIndex::read(*written, map);
  return {};
} catch (const std::exception& e) {
  return {e.what()};
}

}  // namespace facetloc
