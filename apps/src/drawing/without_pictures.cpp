// SPDX-License-Identifier: BSD-3-Clause
// A build without VTK (FACETLOC_WITH_VTK): it has pages and no pictures, and all who draw ask
// OffscreenDisplay first.
#include "drawing/map_page.h"
#include "drawing/offscreen_display.h"

#include <stdexcept>

namespace facetloc {
namespace {

[[noreturn]] void refuse() { throw std::logic_error(kWithoutVtk); }

}  // namespace

bool displayUsable() { return false; }
OffscreenDisplay::OffscreenDisplay() : problem_(kWithoutVtk) {}
OffscreenDisplay::~OffscreenDisplay() = default;

void drawSegmentation(const std::filesystem::path&, const SeenImage&) { refuse(); }
void drawFloorMap(const std::filesystem::path&, const Map&, const std::vector<DrawnRun>&,
                  const std::vector<DrawnMarks>&, const OccupancyGrid*) {
  refuse();
}
void drawRuns(const std::filesystem::path&, const PlanView&, const std::vector<DrawnRun>&) { refuse(); }
void drawBeliefs(const std::filesystem::path&, const Map&, const std::vector<PageAnswer>&,
                 const std::vector<std::string>&) {
  refuse();
}
Raster<std::uint8_t> matchesPicture(const SeenImage&, const Map&, const std::vector<DrawnMatch>&) {
  refuse();
}
Raster<std::uint8_t> contactSheet(const std::vector<Raster<std::uint8_t>>&, const std::vector<std::string>&) {
  refuse();
}

}  // namespace facetloc
