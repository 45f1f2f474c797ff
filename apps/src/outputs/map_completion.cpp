// SPDX-License-Identifier: BSD-3-Clause
#include "outputs/map_completion.h"

#include "batch/map_watch.h"
#include "outputs/provenance.h"

#include <facetloc/io/error.h>
#include <facetloc/localization/place_index.h>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

bool hasItsIndex(const Map& map) {
  const auto written = map.store() ? map.store()->placeIndex() : nullptr;
  return written && PlaceIndex::read(*written, map);
}

}  // namespace

std::shared_ptr<Map> MapFile::map() {
  auto map = std::make_shared<Map>(openMap(path_));
  const auto state = map->meta.find(kStateKey);
  whole_ = state == map->meta.end() || state->second == kWhole;
  return map;
}

int MapFile::add(const PackedModel& model) {
  if (std::exchange(whole_, false)) database_.setMeta(kStateKey, kUnderWay);
  return database_.add(model);
}

void MapFile::setWhole() {
  if (!std::exchange(whole_, true)) database_.setMeta(kStateKey, kWhole);
}

void MapFile::setMounting(const Camera& camera, const FoundMounting& found) {
  database_.setCamera(camera);
  console_.out << "the camera is mounted " << found.toString() << "\n";
}

void MapFile::setPlaceIndex(const Map& map) {
  if (!map.camera.mounting || hasItsIndex(map)) return;
  if (const auto index = placeIndexOf(map)) database_.setPlaceIndex(index);
}

void completeMap(const fs::path& path, int threads, const Console& console, bool mounting) {
  MapFile file(path, MapDatabase::open(path), console);
  MapWatch watch(console);
  completeMap(file, {mounting, threads, watch.callback()});
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

Map writeNewMap(const std::string& path, bool overwrite, int threads, const Console& console,
                const std::function<Map()>& make) {
  if (path.empty()) throw UsageError("the map to write is missing: -o OUT.flmap");
  const OutputLock lock = lockTarget(path, overwrite);
  Map map = make();
  writeMap(path, map);
  completeMap(path, threads, console);
  return map;
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
