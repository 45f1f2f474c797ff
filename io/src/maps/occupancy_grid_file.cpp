// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "bytes/files.h"
#include "bytes/yaml_entries.h"
#include "images/depth_file.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/occupancy_grid_file.h>

#include <algorithm>
#include <cmath>
#include <fmt/core.h>

namespace facetloc {
namespace {
using internal::YamlEntry;

constexpr std::uint8_t kUnknownGrey = 205;  // as map_saver writes cells

enum class Mode { trinary, scale, raw };

/** The content of map.yaml. */
struct Description {
  fs::path image;
  double resolution = 0;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // x, y, yaw
  bool negate = false;
  double occupied = 0.65, free = 0.196;
  Mode mode = Mode::trinary;
};

class DescriptionReader {
public:
  DescriptionReader(std::string_view text, const fs::path& source, Findings& findings)
      : source_(source), entries_(internal::yamlEntries(text)), findings_(findings) {}

  Description read() {
    Description d;
    d.image = image();
    d.resolution = number("resolution");
    if (!(d.resolution > 0)) fail("resolution must be positive");
    d.origin = origin();
    if (find("negate")) d.negate = negate();
    if (find("occupied_thresh")) d.occupied = number("occupied_thresh");
    if (find("free_thresh")) d.free = number("free_thresh");
    if (!(d.free >= 0 && d.free < d.occupied && d.occupied <= 1))
      fail("free_thresh must be less than occupied_thresh, and both must lie in [0, 1]");
    if (find("mode")) d.mode = mode(word("mode"));
    return d;
  }

private:
  [[noreturn]] void fail(const std::string& cause) const { throw IoError(source_.string(), cause); }

  const YamlEntry* find(std::string_view key) const {
    const auto found = std::find_if(entries_.begin(), entries_.end(),
                                    [key](const YamlEntry& entry) { return entry.key == key; });
    return found == entries_.end() ? nullptr : &*found;
  }
  const YamlEntry& need(const char* key) const {
    const YamlEntry* entry = find(key);
    if (!entry) fail(fmt::format("lacks '{}:', which a map_server file of an occupancy grid has", key));
    return *entry;
  }
  std::string word(const char* key) const {
    const YamlEntry& entry = need(key);
    return entry.words.empty() ? std::string() : entry.words.front();
  }
  double number(const char* key) const {
    const YamlEntry& entry = need(key);
    if (entry.numbers.size() != 1 || !std::isfinite(entry.numbers[0]))
      fail(fmt::format("'{}:' needs one finite number", key));
    return entry.numbers[0];
  }
  Eigen::Vector3d origin() const {
    const std::vector<double>& values = need("origin").numbers;
    if (values.size() != 3 ||
        !std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); }))
      fail("'origin:' needs three finite numbers, [x, y, yaw]");
    return {values[0], values[1], values[2]};
  }
  bool negate() const {
    if (const std::string said = word("negate"); said == "true" || said == "false") return said == "true";
    const double value = number("negate");
    if (value != 0 && value != 1) fail("'negate:' must be 0 or 1");
    return value == 1;
  }
  Mode mode(const std::string& word) const {
    if (word == "trinary") return Mode::trinary;
    if (word == "scale") return Mode::scale;
    if (word == "raw") return Mode::raw;
    fail(fmt::format("'mode: {}' is unknown; there are trinary, scale and raw", word));
  }
  fs::path image() {
    const std::string name = word("image");
    if (name.empty()) fail("'image:' names no file");
    const fs::path path = source_.parent_path() / name;
    // map_saver writes the path on the machine that made the plan.
    const fs::path moved = source_.parent_path() / name.substr(name.find_last_of("/\\") + 1);
    if (files::isThere(path) || !files::isFile(moved)) return path;
    findings_.push_back({"plan.image", Severity::note,
                         fmt::format("'image: {}' is not there: {} beside {} is taken", name,
                                     moved.filename().string(), source_.filename().string()),
                         ""});
    return moved;
  }

  const fs::path& source_;
  std::vector<YamlEntry> entries_;
  Findings& findings_;
};

Greymap greymapOf(const fs::path& path) {
  if (pngSize(path)) {
    Greymap map;
    map.image = readGreyPng(path);
    map.white = pngSize(path)->bits > 8 ? 65535 : 255;
    return map;
  }
  return parsePgm(path.string(), files::readBytes(path));
}

Greymap readImage(const fs::path& path) {
  files::requireRegularFile(path);
  try {
    return greymapOf(path);
  } catch (const IoError& e) {
    throw IoError(path.string(),
                  e.cause() + "; save it as grey of 8 bits: convert PLAN -colorspace gray -depth 8 plan.pgm");
  }
}

/** As map_server has it; the probability of occupation grows with darkness. */
std::int8_t cellOf(std::uint16_t value, int white, const Description& d) {
  constexpr int kLargest = 100;
  const double share = static_cast<double>(value) / white;
  if (d.mode == Mode::raw) {
    const auto raw = static_cast<int>(std::lround(255 * share));
    return raw <= kLargest ? static_cast<std::int8_t>(raw) : OccupancyGrid::kUnknown;
  }
  const double occupied = d.negate ? share : 1 - share;
  if (occupied > d.occupied) return OccupancyGrid::kOccupied;
  if (occupied < d.free) return OccupancyGrid::kFree;
  if (d.mode == Mode::trinary) return OccupancyGrid::kUnknown;
  return static_cast<std::int8_t>(std::lround(1 + 98 * (occupied - d.free) / (d.occupied - d.free)));
}

/** map_saver's grey of unknown cells stays unknown, even if free_thresh counts it as free; not in a plan
 * whose free cells all have that grey. */
void keepUnknown(const Raster<std::uint16_t>& image, int white, const Description& d, OccupancyGrid& grid,
                 Findings& findings) {
  if (d.mode == Mode::raw || d.negate) return;
  std::vector<std::size_t> grey;
  bool has_others = false;
  for (int row = 0; row < grid.height; ++row)
    for (int column = 0; column < grid.width; ++column) {
      const std::size_t cell = grid.index(column, row);
      if (grid.cells[cell] != OccupancyGrid::kFree) continue;
      const double value = image.data[grid.index(column, grid.height - 1 - row)];
      if (std::lround(255 * value / white) == kUnknownGrey)
        grey.push_back(cell);
      else
        has_others = true;
    }
  if (grey.empty() || !has_others) return;
  for (const std::size_t cell : grey) grid.cells[cell] = OccupancyGrid::kUnknown;
  findings.push_back(
      {"plan.unknown",
       Severity::note,
       fmt::format(
           "{} of {} cells have the grey {} of unknown ones, which free_thresh {} counts as free: they "
           "are taken as unknown",
           grey.size(), grid.cells.size(), kUnknownGrey, d.free),
       "free_thresh: 0.196 is usual",
       {{"cells", static_cast<double>(grey.size())}}});
}

}  // namespace

OccupancyGrid readOccupancyGrid(const fs::path& yaml, Findings* findings) {
  const std::string text = files::readText(yaml);
  Findings found;
  const Description d = DescriptionReader(text, yaml, found).read();
  const auto [image, white] = readImage(d.image);
  OccupancyGrid grid = OccupancyGrid::filled(image.width, image.height, d.resolution, d.origin.head<2>(),
                                             OccupancyGrid::kUnknown);
  grid.yaw = d.origin.z();
  for (int row = 0; row < grid.height; ++row)
    for (int column = 0; column < grid.width; ++column)
      grid.cells[grid.index(column, row)] =
          cellOf(image.data[grid.index(column, grid.height - 1 - row)], white, d);
  keepUnknown(image, white, d, grid, found);
  if (findings) append(std::move(found), *findings);
  return grid;
}

void writeOccupancyGrid(const fs::path& yaml, const OccupancyGrid& grid) {
  constexpr std::uint8_t kBlack = 0, kWhite = 254;
  Raster<std::uint8_t> image;
  image.width = grid.width, image.height = grid.height;
  image.data.reserve(grid.cells.size());
  for (int row = grid.height - 1; row >= 0; --row)
    for (int column = 0; column < grid.width; ++column)
      image.data.push_back(grid.isOccupied(column, row) ? kBlack
                           : grid.isFree(column, row)   ? kWhite
                                                        : kUnknownGrey);
  const fs::path pgm = fs::path(yaml).replace_extension(".pgm");
  writePgm(pgm, image);
  writeTextAtomically(yaml, [&](std::ostream& out) {
    const auto number = [](double value) { return text::shortest(value); };
    out << "image: " << pgm.filename().string() << "\nmode: trinary\nresolution: " << number(grid.resolution)
        << "\norigin: [" << number(grid.origin.x()) << ", " << number(grid.origin.y()) << ", "
        << number(grid.yaw) << "]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
  });
}

fs::path occupancyGridPath(const fs::path& name) {
  const std::string extension = text::lowerExtension(name);
  if (extension == ".yaml" || extension == ".yml") return name;
  if (!name.has_filename() || files::isFolder(name)) return name / "map.yaml";
  return fs::path(name) += ".yaml";
}

}  // namespace facetloc
