// SPDX-License-Identifier: BSD-3-Clause
// A map.yaml and, behind the line "---", its image.
#include "fuzz_file.h"

#include <facetloc/io/error.h>
#include <facetloc/io/occupancy_grid_file.h>

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
  });
  return 0;
}
