// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/map_surfaces.h>

namespace facetloc {
namespace {

constexpr const char* kFixed = "fixed";
constexpr const char* kIncomplete = "incomplete";

}  // namespace

MapSurfaces surfacesOf(const Map& map) {
  const auto found = map.meta.find(kSurfacesKey);
  if (found == map.meta.end()) return MapSurfaces::seen;
  return found->second == kFixed        ? MapSurfaces::fixed
         : found->second == kIncomplete ? MapSurfaces::incomplete
                                        : MapSurfaces::seen;
}

void setSurfaces(MapSurfaces surfaces, Map& map) {
  if (surfaces == MapSurfaces::seen)
    map.meta.erase(kSurfacesKey);
  else
    map.meta[kSurfacesKey] = surfaces == MapSurfaces::fixed ? kFixed : kIncomplete;
}

}  // namespace facetloc
