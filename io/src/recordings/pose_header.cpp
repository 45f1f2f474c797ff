// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/pose_header.h"

#include "base/text.h"

#include <algorithm>
#include <cctype>
#include <string>
#include <vector>

namespace facetloc::internal {
namespace {

constexpr double kNanoseconds = 1e-9, kMicroseconds = 1e-6, kMilliseconds = 1e-3;
constexpr int kNone = -1;

/** Index in qx qy qz qw; kNone for other columns. */
int quaternionPart(const ColumnName& name) {
  const bool is_quaternion = name.begins("q") || name.has("orient") || name.has("rot") || name.has("quat");
  const auto part = std::string_view("xyzw").find(name.last());
  return is_quaternion && part != std::string_view::npos ? static_cast<int>(part) : kNone;
}

/** Index in tx ty tz; kNone for other columns. */
int positionPart(const ColumnName& name) {
  const bool is_position =
      name.word.size() == 1 || name.begins("t") || name.begins("p") || name.has("pos") || name.has("trans");
  const auto part = std::string_view("xyz").find(name.last());
  return is_position && part != std::string_view::npos ? static_cast<int>(part) : kNone;
}

}  // namespace

std::vector<ColumnName> columnNames(std::string_view line) {
  const char separator = line.find(',') != std::string_view::npos   ? ','
                         : line.find(';') != std::string_view::npos ? ';'
                                                                    : ' ';
  std::vector<ColumnName> names;
  const auto cells = separator == ' ' ? text::words(line) : text::split(line, separator);
  for (const std::string_view cell : cells) {
    ColumnName name;
    bool in_brackets = false;
    for (const char c : text::trimmed(cell)) {
      if (c == '[' || c == '(') in_brackets = true;
      const char folded = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      if (std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.')
        (in_brackets ? name.unit : name.word) += folded;
      if (c == ']' || c == ')') in_brackets = false;
    }
    if (name.word.empty() && !name.unit.empty() && !names.empty())
      names.back().unit = name.unit;
    else
      names.push_back(std::move(name));
  }
  return names;
}

bool ColumnName::isStamp() const {
  return has("time") || has("stamp") || word == "t" || word == "sec" || word == "secs";
}

double ColumnName::seconds() const {
  const auto says = [this](const char* the_unit) {
    const std::string ending = std::string("_") + the_unit;
    const bool ends =
        word.size() > ending.size() && word.compare(word.size() - ending.size(), ending.size(), ending) == 0;
    return unit == the_unit || ends;
  };
  if (says("ns") || says("nsec")) return kNanoseconds;
  if (says("us") || says("usec")) return kMicroseconds;
  if (says("ms") || says("msec")) return kMilliseconds;
  return says("s") || says("sec") ? 1 : 0;
}

std::optional<PoseHeader> PoseHeader::of(std::string_view line) {
  const std::vector<ColumnName> names = columnNames(line);
  PoseHeader header;
  header.width = names.size();
  header.pose.fill(kNone);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const int column = static_cast<int>(i), q = quaternionPart(names[i]), t = positionPart(names[i]);
    if (names[i].begins("nsec") || names[i].begins("nanosec")) {
      header.nanoseconds = column;
      continue;
    }
    if (names[i].isStamp()) {
      if (header.stamp == kNone) header.stamp = column, header.unit = names[i].seconds();
      continue;
    }
    if (q == kNone && t == kNone) continue;
    int& place = header.pose[static_cast<std::size_t>(q != kNone ? 3 + q : t)];
    if (place != kNone) return {};  // several poses are ambiguous
    place = column;
  }
  if (std::count(header.pose.begin(), header.pose.end(), kNone) > 0) return {};
  if (header.nanoseconds != kNone) header.unit = 1;
  return header;
}

PoseHeader PoseHeader::inOrder(std::size_t width, int stamp, int first) {
  PoseHeader header;
  header.width = width;
  header.stamp = stamp;
  for (std::size_t k = 0; k < header.pose.size(); ++k) header.pose[k] = first + static_cast<int>(k);
  return header;
}

PoseHeader PoseHeader::ofMatrix(std::size_t width, int stamp, int first) {
  PoseHeader header;
  header.width = width;
  header.stamp = stamp;
  header.matrix = first;
  return header;
}

PoseHeader PoseHeader::ofEuroc(std::size_t width) {
  PoseHeader header = inOrder(width, 0, 1);
  header.unit = kNanoseconds;
  header.pose[6] = 4, header.pose[3] = 5, header.pose[4] = 6, header.pose[5] = 7;
  return header;
}

}  // namespace facetloc::internal
