// SPDX-License-Identifier: BSD-3-Clause
#include "base/place_index_file.h"

#include <facetloc/io/map_database.h>
#include <facetloc/localization/place_index.h>

namespace facetloc {

void writePlaceIndex(const std::filesystem::path& path) {
  const Map map = openMap(path);
  if (!map.camera.mounting || !map.store) return;
  if (const auto written = map.store->placeIndex(); written && PlaceIndex::read(*written, map)) return;
  const PlaceIndex index(map);
  MapDatabase::open(path).setPlaceIndex([&index](std::ostream& out) { index.write(out); });
}

std::vector<std::string> placeIndexFaults(const std::filesystem::path& path) try {
  const Map map = openMap(path, 0);
  const auto written = map.camera.mounting ? map.store->placeIndex() : nullptr;
  if (written) PlaceIndex::read(*written, map);
  return {};
} catch (const std::exception& e) {
  return {e.what()};
}

}  // namespace facetloc
