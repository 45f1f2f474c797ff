// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "bytes/files.h"
#include "bytes/plausible.h"
#include "recordings/name_numbers.h"
#include "recordings/pose_table.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/gravity_record.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <stdexcept>
#include <string_view>

namespace facetloc {

using internal::ColumnName;

namespace {

constexpr double kStampRounding = 1e-6;  // [s] stamps are written with 6 decimals
constexpr double kWidestGap = 5;         // between samples to interpolate, by the tolerance
constexpr int kNone = -1;

/** Meaning of the columns of a file. */
struct Columns {
  std::size_t width = 4;
  int stamp = 0, std_deg = kNone;
  std::array<int, 3> gravity{1, 2, 3};
  double unit = 0;  // seconds of a stamp; 0: unknown
};

bool isComment(std::string_view line) { return line.front() == '#' || line.front() == '%'; }

/** The cells of a line, between commas or semicolons, if there are any, or else between blanks. */
std::vector<std::string_view> cellsOf(std::string_view line) {
  const char separator = line.find(';') != std::string_view::npos ? ';' : ',';
  if (line.find(separator) == std::string_view::npos) return text::words(line);
  std::vector<std::string_view> cells = text::split(line, separator);
  for (std::string_view& cell : cells) cell = text::trimmed(cell);
  return cells;
}

/** gx, g_x, gravity_x, gravity.x: 0 to 2; kNone for others. */
int gravityPart(const ColumnName& name) {
  const auto part = std::string_view("xyz").find(name.last());
  if (part == std::string_view::npos || name.word.size() < 2) return kNone;
  const std::string stem = name.word.substr(0, name.word.size() - 1);
  const bool is_gravity = stem == "g" || stem == "g_" || stem == "g." || name.has("grav");
  return is_gravity ? static_cast<int>(part) : kNone;
}

std::optional<Columns> columnsOf(std::string_view line) {
  const std::vector<ColumnName> names = internal::columnNames(line);
  Columns columns{names.size(), kNone, kNone, {kNone, kNone, kNone}, 0};
  for (std::size_t i = 0; i < names.size(); ++i) {
    const int column = static_cast<int>(i), part = gravityPart(names[i]);
    if (part != kNone && columns.gravity[static_cast<std::size_t>(part)] == kNone)
      columns.gravity[static_cast<std::size_t>(part)] = column;
    else if (names[i].word == "std_deg")
      columns.std_deg = column;
    else if (columns.stamp == kNone && names[i].isStamp())
      columns.stamp = column, columns.unit = names[i].seconds();
  }
  const bool is_whole = std::count(columns.gravity.begin(), columns.gravity.end(), kNone) == 0;
  return is_whole && columns.stamp != kNone ? std::optional(columns) : std::nullopt;
}

double numberIn(const std::vector<std::string_view>& cells, int column) {
  const std::string_view cell = cells[static_cast<std::size_t>(column)];
  const auto number = text::to<double>(cell);
  if (!number || !std::isfinite(*number))
    throw std::invalid_argument(text::quoted(cell) + " is not a finite number");
  return *number;
}

StampedGravity sampleOf(const std::vector<std::string_view>& cells, const Columns& columns, double std) {
  if (cells.size() != columns.width)
    throw std::invalid_argument(fmt::format("has {} columns instead of {}", cells.size(), columns.width));
  Eigen::Vector3d g;
  for (int k = 0; k < 3; ++k) g[k] = numberIn(cells, columns.gravity[static_cast<std::size_t>(k)]);
  const double of_line = columns.std_deg == kNone ? std : numberIn(cells, columns.std_deg) * kDegree;
  return {numberIn(cells, columns.stamp), gravityAlong(g, of_line)};
}

/** Stamps become seconds. */
void setTimes(std::vector<StampedGravity>& samples, double unit, const std::string& path) {
  std::vector<double> stamps;
  for (const StampedGravity& sample : samples) stamps.push_back(sample.stamp);
  if (!(unit > 0)) unit = internal::unitOfStamps(std::move(stamps)).seconds;
  for (StampedGravity& sample : samples) {
    sample.stamp *= unit;
    if (!plausible::isStamp(sample.stamp)) throw IoError(path, "has stamps that are impossible");
  }
}

/** The columns by the first line that says something: of names, or of four numbers. */
std::optional<Columns> columnsOfFile(std::string_view content) {
  for (std::string_view line : text::lines(content)) {
    line = text::trimmed(line);
    if (line.empty()) continue;
    if (const auto named = columnsOf(isComment(line) ? line.substr(1) : line)) return named;
    if (isComment(line)) continue;
    const auto cells = cellsOf(line);
    if (cells.size() == Columns().width && text::to<double>(cells.front())) return Columns();
    return {};
  }
  return {};
}

}  // namespace

GravityRecord::GravityRecord(std::vector<StampedGravity> samples) : samples_(std::move(samples)) {
  std::stable_sort(samples_.begin(), samples_.end(),
                   [](const StampedGravity& a, const StampedGravity& b) { return a.stamp < b.stamp; });
}

std::optional<Gravity> GravityRecord::at(double stamp, double tolerance) const {
  const auto after = std::lower_bound(samples_.begin(), samples_.end(), stamp,
                                      [](const StampedGravity& s, double t) { return s.stamp < t; });
  const StampedGravity* nearest = after == samples_.end() ? nullptr : &*after;
  if (after != samples_.begin()) {
    const StampedGravity& before = after[-1];
    if (nearest && nearest->stamp - before.stamp <= kWidestGap * tolerance + kStampRounding) {
      const double share = (stamp - before.stamp) / (nearest->stamp - before.stamp);
      const Eigen::Vector3d down = (1 - share) * before.gravity.down + share * nearest->gravity.down;
      const double std = std::max(before.gravity.std, nearest->gravity.std);
      constexpr double kLeast = 0.1;  // length of a mean of two similar directions
      if (down.norm() > kLeast) return Gravity{down.normalized(), std};
    }
    if (!nearest || stamp - before.stamp <= nearest->stamp - stamp) nearest = &before;
  }
  if (!nearest || !(std::abs(nearest->stamp - stamp) <= tolerance + kStampRounding)) return {};
  return nearest->gravity;
}

bool holdsGravity(const fs::path& path) { return columnsOfFile(files::readText(path)).has_value(); }

GravityRecord readGravity(const fs::path& path, double std) {
  const std::string content = files::readText(path);
  const auto columns = columnsOfFile(content);
  if (!columns)
    throw IoError(path.string(),
                  "has no gravity: lines are stamp gx gy gz, or the first one names its columns");
  std::vector<StampedGravity> samples;
  files::forEachLine(content, path.string(), [&](std::string_view line) {
    line = text::trimmed(line);
    if (line.empty() || isComment(line) || (samples.empty() && columnsOf(line))) return;
    samples.push_back(sampleOf(cellsOf(line), *columns, std));
  });
  if (samples.empty()) throw IoError(path.string(), "has no line of gravity");
  setTimes(samples, columns->unit, path.string());
  return GravityRecord(std::move(samples));
}

GravityRecord gravityOf(const Trajectory& poses, const Eigen::Vector3d& up_w, double std) {
  std::vector<StampedGravity> samples;
  for (const StampedPose& pose : poses.poses())
    samples.push_back({pose.stamp, gravityAlong(-(pose.T_w_c.linear().transpose() * up_w), std)});
  return GravityRecord(std::move(samples));
}

void writeGravity(const fs::path& path, const std::vector<StampedGravity>& samples) {
  constexpr int kStampDigits = 6;
  writeTextAtomically(path, [&](std::ostream& out) {
    out << "# timestamp gx gy gz\n";
    for (const auto& [stamp, gravity] : samples) {
      out << text::decimals(stamp, kStampDigits);
      for (int k = 0; k < 3; ++k) out << ' ' << text::significant(gravity.down[k]);
      out << '\n';
    }
  });
}

}  // namespace facetloc
