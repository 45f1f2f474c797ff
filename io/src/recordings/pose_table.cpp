// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/pose_table.h"

#include "base/text.h"
#include "bytes/files.h"
#include "bytes/plausible.h"
#include "results/pose_columns.h"

#include <Eigen/LU>
#include <Eigen/SVD>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fmt/format.h>
#include <numeric>
#include <stdexcept>

namespace facetloc::internal {
namespace {

constexpr double kTolerance =
    1e-2;  // tolerance of |q|^2 and of a rotation matrix: files have as few as four decimals
constexpr double kNoRotation = 1e-9;

constexpr double kNanoseconds = 1e-9, kMicroseconds = 1e-6, kMilliseconds = 1e-3;
constexpr int kNone = -1;

/** Index of the axis that a name ends with, if it is such a name; kNone for other columns. */
int partOf(const ColumnName& name, std::string_view axes, bool is_such) {
  const auto part = axes.find(name.last());
  return is_such && part != std::string_view::npos ? static_cast<int>(part) : kNone;
}

int quaternionPart(const ColumnName& name) {
  return partOf(name, "xyzw", name.begins("q") || name.has("orient") || name.has("rot") || name.has("quat"));
}

int positionPart(const ColumnName& name) {
  return partOf(name, "xyz",
                name.word.size() == 1 || name.begins("t") || name.begins("p") || name.has("pos") ||
                    name.has("trans"));
}

/** Columns, counted from 0. */
struct PoseHeader {
  std::size_t width = 0;      ///< number of columns
  int stamp = -1;             ///< -1: none
  int nanoseconds = -1;       ///< column with the part of the stamp below a second; -1: none
  double unit = 0;            ///< seconds that a stamp stands for, if the header says it; 0: it does not
  int matrix = -1;            ///< where a matrix begins, row by row; -1: a position and a quaternion instead
  std::array<int, 7> pose{};  ///< tx ty tz qx qy qz qw

  /** Columns by a line of names, such as `timestamp tx ty tz qx qy qz qw` or EuRoC's `#timestamp
   * [ns],p_x,...`. Empty if the names are not those of one position and one quaternion. */
  static std::optional<PoseHeader> of(std::string_view names);
};

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

/** tx ty tz qx qy qz qw from a column on. */
std::array<int, 7> inOrder(int first) {
  std::array<int, 7> pose{};
  std::iota(pose.begin(), pose.end(), first);
  return pose;
}

/** A line of numbers. */
struct Line {
  int number = 0;
  std::vector<double> values;
};

/** 0,25 between blanks or semicolons; not 1,2,3. */
bool hasDecimalCommas(std::string_view line) {
  if (line.find('.') != std::string_view::npos) return false;
  if (line.find(';') != std::string_view::npos) return line.find(',') != std::string_view::npos;
  const auto words = text::words(line);
  return words.size() > 1 && std::all_of(words.begin(), words.end(), [](std::string_view word) {
           return std::count(word.begin(), word.end(), ',') <= 1 && word.back() != ',' && word.front() != ',';
         });
}

/** With points for decimals and blanks between the cells. */
std::string spaced(std::string_view line) {
  std::string out(line);
  const bool decimal_commas = hasDecimalCommas(line);
  for (char& c : out)
    if (c == ',' || c == ';') c = c == ',' && decimal_commas ? '.' : ' ';
  return out;
}

class TableParser {
public:
  explicit TableParser(std::string source) : source_(std::move(source)) {}

  PoseTable parse(std::string_view content) {
    for (const std::string_view line : text::lines(content)) {
      ++number_;
      addLine(text::trimmed(line));
    }
    if (lines_.empty() && unknown_ > 0) fail(unknown_, "has no numbers, and no names of columns of poses");
    if (lines_.empty()) return {};
    return isOfMatrices() ? ofMatrices() : ofRows();
  }

private:
  [[noreturn]] void fail(int line, const std::string& cause) const {
    throw IoError(source_, fmt::format("line {}: {}", line, cause));
  }

  void addLine(std::string_view line) {
    if (line.empty()) return;
    if (line.front() == '#' || line.front() == '%') return takeNames(line.substr(1));
    const std::string cells = spaced(text::withoutComment(line));
    const auto words = text::words(cells);
    if (words.empty()) return;
    if (lines_.empty() && !text::to<double>(words[0]) && isOfNames(line)) {
      takeNames(line);
      if (!header_) unknown_ = number_;
      return;
    }
    Line row{number_, {}};
    for (const std::string_view word : words) {
      const auto value = text::to<double>(word);
      if (!value) fail(number_, text::quoted(word) + " is not a number");
      row.values.push_back(*value);
    }
    lines_.push_back(std::move(row));
  }

  /** No digit in front of a word, and no control characters, as binary files have them. */
  static bool isOfNames(std::string_view line) {
    const auto words = text::words(line);
    return std::none_of(line.begin(), line.end(),
                        [](char c) { return static_cast<unsigned char>(c) < ' ' && c != '\t'; }) &&
           std::none_of(words.begin(), words.end(), [](std::string_view word) {
             return std::isdigit(static_cast<unsigned char>(word.front())) != 0;
           });
  }

  void takeNames(std::string_view line) {
    if (!lines_.empty()) return;
    if (const auto names = PoseHeader::of(line)) header_ = names;
  }

  /** Rows of four numbers, four to a pose, or of three numbers before these. */
  bool isOfMatrices() const {
    const std::size_t first = lines_[0].values.size();
    if (first == 4) return true;
    return first == 3 && lines_.size() > 1 && lines_[1].values.size() == 4;
  }

  PoseTable ofMatrices() const {
    PoseTable table;
    table.stamped = false;
    const bool numbered = lines_[0].values.size() == 3;
    for (std::size_t i = 0; i < lines_.size();) {
      if (numbered && lines_[i++].values.size() != 3)
        fail(lines_[i - 1].number, "is no line of three numbers");
      Eigen::Matrix4d m;
      for (int r = 0; r < 4; ++r, ++i) {
        if (i >= lines_.size() || lines_[i].values.size() != 4)
          fail(i < lines_.size() ? lines_[i].number : lines_.back().number,
               "matrices of 4x4 have four rows of four numbers");
        for (int c = 0; c < 4; ++c) m(r, c) = lines_[i].values[static_cast<std::size_t>(c)];
      }
      table.rows.push_back({0, guarded(lines_[i - 1].number, [&] { return poseOrLost(m); })});
    }
    return table;
  }

  PoseTable ofRows() const {
    const std::size_t width = lines_[0].values.size();
    const PoseHeader columns = columnsFor(width);
    PoseTable table;
    table.stamped = columns.stamp >= 0;
    for (const Line& line : lines_) {
      if (line.values.size() != width)
        fail(line.number, fmt::format("has {} columns instead of {}", line.values.size(), width));
      PoseRow row;
      row.T_w_c = guarded(line.number, [&] { return poseIn(columns, line.values); });
      if (table.stamped) {
        row.stamp = stampIn(columns, line.values);
        if (!std::isfinite(row.stamp)) {
          if (!row.T_w_c) continue;
          fail(line.number, "its stamp is not a finite number");
        }
      }
      table.rows.push_back(row);
    }
    if (!table.stamped) return table;
    table.unit = columns.unit > 0 ? TimeUnit{columns.unit} : unitOfStamps(table.stamps());
    for (std::size_t i = 0; i < table.rows.size(); ++i)
      if (!plausible::isStamp(table.rows[i].stamp * table.unit.seconds))
        throw IoError(source_,
                      fmt::format("a stamp of {} is impossible", text::shortest(table.rows[i].stamp)));
    return table;
  }

  template <typename Work>
  auto guarded(int line, const Work& work) const -> decltype(work()) {
    try {
      return work();
    } catch (const std::invalid_argument& e) {
      fail(line, e.what());
    }
  }

  PoseHeader columnsFor(std::size_t width) const {
    if (header_ && header_->width == width) return *header_;
    constexpr std::size_t kPose = 7, kMatrix34 = 12, kMatrix44 = 16, kEuroc = 17;
    switch (width) {
    case kPose:
      return {width, kNone, kNone, 0, kNone, inOrder(0)};
    case kPose + 1:
      return {width, 0, kNone, 0, kNone, inOrder(1)};
    case kPose + 2: {  // with another number in front or behind
      const int stamp = isRotationAt(5) && !isRotationAt(4) ? 1 : 0;
      return {width, stamp, kNone, 0, kNone, inOrder(stamp + 1)};
    }
    case kMatrix34:
    case kMatrix44:
      return {width, kNone, kNone, 0, 0};
    case kEuroc:
      if (!endsAsMatrix()) return {width, 0, kNone, kNanoseconds, kNone, {1, 2, 3, 5, 6, 7, 4}};
      [[fallthrough]];
    case kMatrix34 + 1:
      return {width, 0, kNone, 0, 1};
    default:
      fail(lines_[0].number,
           fmt::format(
               "has {} columns instead of 8: poses are read as tx ty tz qx qy qz qw, or as the 12 or 16 "
               "numbers of a matrix, with a stamp in front or in the order of the images, or as a "
               "first line of names says (timestamp, tx, ..., qw)",
               width));
    }
  }

  /** Four numbers from a column on, in the first row that is not lost. */
  bool isRotationAt(std::size_t column) const {
    for (const Line& line : lines_) {
      if (line.values.size() < column + 4) return false;
      const Eigen::Map<const Eigen::Vector4d> q(line.values.data() + column);
      if (q.allFinite() && q.norm() > kNoRotation) return std::abs(q.squaredNorm() - 1) <= kTolerance;
    }
    return false;
  }

  bool endsAsMatrix() const {
    const std::vector<double>& v = lines_[0].values;
    return v.size() >= 4 && std::equal(v.end() - 4, v.end(), std::begin({0.0, 0.0, 0.0, 1.0}));
  }

  static double stampIn(const PoseHeader& columns, const std::vector<double>& values) {
    const double stamp = values[static_cast<std::size_t>(columns.stamp)];
    if (columns.nanoseconds < 0) return stamp;
    return stamp + 1e-9 * values[static_cast<std::size_t>(columns.nanoseconds)];
  }

  static std::optional<Eigen::Isometry3d> poseOrLost(const Eigen::Matrix4d& m) {
    if (!m.allFinite() || m.topLeftCorner<3, 3>().norm() < kNoRotation) return {};
    return poseOfMatrix(m);
  }

  static std::optional<Eigen::Isometry3d> poseIn(const PoseHeader& columns,
                                                 const std::vector<double>& values) {
    const auto value = [&values](int column) { return values[static_cast<std::size_t>(column)]; };
    if (columns.matrix >= 0) {
      Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
      const int rows = static_cast<int>(values.size()) - columns.matrix >= 16 ? 4 : 3;
      for (int k = 0; k < 4 * rows; ++k) m(k / 4, k % 4) = value(columns.matrix + k);
      return poseOrLost(m);
    }
    PoseColumns pose;
    for (std::size_t k = 0; k < pose.size(); ++k) pose[k] = value(columns.pose[k]);
    return poseOfColumns(pose);
  }

  std::string source_;
  int number_ = 0, unknown_ = 0;  // the latter has words that are no names of columns
  std::vector<Line> lines_;
  std::optional<PoseHeader> header_;
};

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
  const auto says = [this](const std::string& the_unit) {
    return unit == the_unit || (word.size() > the_unit.size() + 1 && endsWith(word, "_" + the_unit));
  };
  if (says("ns") || says("nsec")) return kNanoseconds;
  if (says("us") || says("usec")) return kMicroseconds;
  if (says("ms") || says("msec")) return kMilliseconds;
  return says("s") || says("sec") ? 1 : 0;
}

std::size_t PoseTable::lost() const {
  return static_cast<std::size_t>(
      std::count_if(rows.begin(), rows.end(), [](const PoseRow& row) { return !row.T_w_c; }));
}

std::vector<double> PoseTable::stamps() const {
  std::vector<double> stamps;
  for (const PoseRow& row : rows) stamps.push_back(row.stamp);
  return stamps;
}

Eigen::Isometry3d poseOfMatrix(const Eigen::Matrix4d& m, const std::string& subject) {
  const Eigen::Matrix3d R = m.topLeftCorner<3, 3>();
  const bool is_rotation =
      (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() <= kTolerance &&
      R.determinant() > 0;
  if (!is_rotation || m.row(3) != Eigen::RowVector4d(0, 0, 0, 1))
    throw std::invalid_argument(subject + "is a matrix that is not a pose");
  if (!plausible::isPosition(m.topRightCorner<3, 1>()))
    throw std::invalid_argument(subject + "is more than 1000 km away");
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = svd.matrixU() * svd.matrixV().transpose();  // the nearest rotation
  T.translation() = m.topRightCorner<3, 1>();
  return T;
}

std::optional<Eigen::Isometry3d> poseOfColumns(const PoseColumns& columns) {
  const bool finite = std::all_of(columns.begin(), columns.end(), [](double x) { return std::isfinite(x); });
  const Eigen::Map<const Eigen::Vector4d> q(columns.data() + 3);
  if (!finite || q.norm() < kNoRotation) return {};
  return fromColumns(columns, kTolerance);
}

std::vector<double> numbersOf(std::string_view content, const fs::path& path) {
  std::vector<double> numbers;
  for (const std::string_view word : text::words(content)) {
    const auto number = text::to<double>(word);
    if (!number) throw IoError(path.string(), text::quoted(word) + " is not a number");
    numbers.push_back(*number);
  }
  return numbers;
}

PoseTable parsePoseTable(std::string_view content, const std::string& source) {
  return TableParser(source).parse(content);
}

PoseTable readPoseTable(const fs::path& path) { return parsePoseTable(files::readText(path), path.string()); }

}  // namespace facetloc::internal
