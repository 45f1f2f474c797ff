// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/apps/place_index_file.h>
#include <facetloc/io/map_database.h>
#include <facetloc/registration/place_index.h>

namespace facetloc {

void writePlaceIndex(const std::filesystem::path& path) {
  MapDatabase database = MapDatabase::open(path);
  if (database.hasPlaceIndex()) return;
  const Map map = openMap(path);
  if (!map.mounting) return;
  const PlaceIndex index(map);
  database.setPlaceIndex([&index](std::ostream& out) { index.write(out); });
}

}  // namespace facetloc
