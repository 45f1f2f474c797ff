// SPDX-License-Identifier: BSD-3-Clause
// A map.yaml and, behind the line "---", its image. The walls of a small plan are extruded.
#include "fuzz_file.h"

#include <facetloc/io/error.h>
#include <facetloc/io/occupancy_grid_file.h>
#include <facetloc/mapping/floor_plan.h>

#include <cmath>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc;
  static const fuzz::Folder folder;
  constexpr std::string_view kBreak = "\n---\n";
  const std::string_view text = fuzz::asText(data, size);
  const std::size_t end = text.find(kBreak);
  folder.clear();
  if (end != std::string_view::npos) folder.put("a.pgm", text.substr(end + kBreak.size()));
  const auto yaml = folder.put("map.yaml", text.substr(0, end));
  fuzz::accepts<IoError>([&] {
    const OccupancyGrid grid = readOccupancyGrid(yaml);
    fuzz::require(grid.resolution > 0 && grid.origin.allFinite() && std::isfinite(grid.yaw),
                  "placed nowhere");
    fuzz::require(grid.cells.size() == static_cast<std::size_t>(grid.width) * grid.height, "of another size");
    writeOccupancyGrid(folder.path() / "again.yaml", grid);
    const OccupancyGrid again = readOccupancyGrid(folder.path() / "again.yaml");
    fuzz::require(again.origin == grid.origin && again.resolution == grid.resolution, "moved when written");
    constexpr std::size_t kMostCells = 4096;
    if (grid.cells.size() > kMostCells) return;
    const pcl::PolygonMesh walls = extrude(grid);
    const std::size_t points = static_cast<std::size_t>(walls.cloud.width) * walls.cloud.height;
    for (const pcl::Vertices& face : walls.polygons)
      for (const auto vertex : face.vertices)
        fuzz::require(static_cast<std::size_t>(vertex) < points, "a wall without a corner");
  });
  return 0;
}
