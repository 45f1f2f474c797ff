// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/map_surfaces.h>

namespace facetloc {
namespace {

constexpr const char* kIncomplete = "incomplete";

}  // namespace

bool lacksSurfaces(const Map& map) {
  const auto found = map.meta.find(kSurfacesKey);
  return found != map.meta.end() && found->second == kIncomplete;
}

void setLacksSurfaces(Map& map) { map.meta[kSurfacesKey] = kIncomplete; }

}  // namespace facetloc
