// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "bytes/csv.h"
#include "results/pose_columns.h"

#include <facetloc/io/results.h>
#include <facetloc/io/trajectory.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <fmt/format.h>
#include <stdexcept>

namespace facetloc {
namespace {

constexpr const char* kHypotheses = "hypotheses.csv";
constexpr const char* kTiming = "timing.csv";
constexpr const char* kPoses = "poses_tum.txt";
constexpr const char *kPosesOfPart = "poses_tum.part-", *kPosesEnding = ".txt";
constexpr const char* kCovariances = "covariances.csv";
constexpr const char* kShares = "shares.csv";
constexpr const char* kStarts = "starts.csv";
constexpr const char* kParams = "params.ini";
constexpr double kQuaternionTolerance = 1e-3;  // tolerance of |q|^2 as read
constexpr int kTimeDecimals = 3;               // decimals of milliseconds

using PoseNames = std::vector<std::string>;  // seven
const PoseNames kWorldPose = {"w_tx", "w_ty", "w_tz", "w_qx", "w_qy", "w_qz", "w_qw"};

template <class... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <class... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;

bool isFinite(const ResultRow& row) {
  const auto isFiniteIn =
      Overloaded{[](double value) { return std::isfinite(value); },
                 [](const Eigen::Isometry3d& T) { return T.matrix().allFinite(); },
                 [](const std::optional<Eigen::Isometry3d>& T) { return !T || T->matrix().allFinite(); },
                 [](const std::optional<double>& value) { return !value || std::isfinite(*value); },
                 [](const auto&) { return true; }};
  const auto& columns = resultColumns();
  return (!row.P_w_c || row.P_w_c->allFinite()) &&
         std::all_of(columns.begin(), columns.end(), [&](const ResultColumn& column) {
           return std::visit([&](auto member) { return isFiniteIn(row.*member); }, column.value);
         });
}

void requireWritable(const FrameResult& frame) {
  if (frame.rows.empty()) throw std::invalid_argument("a frame of the results has no row");
  for (const ResultRow& row : frame.rows)
    if (row.rank < 0 || !isFinite(row))
      throw std::invalid_argument(fmt::format("results of frame {} are not finite", row.frame));
}

std::string poseCells(const std::optional<Eigen::Isometry3d>& T) {
  if (!T) return std::string(kWorldPose.size() - 1, ',');
  std::string cells;
  for (const double value : toColumns(*T))
    cells.append(cells.empty() ? "" : ",").append(text::significant(value));
  return cells;
}

std::string cellsOf(const ResultColumn& column, const ResultRow& row) {
  if (row.rank == 0 && !column.has_always) return std::string(column.names().size() - 1, ',');
  return std::visit(
      Overloaded{[&](std::string ResultRow::*text) { return text::csvCell(row.*text); },
                 [&](int ResultRow::*count) { return std::to_string(row.*count); },
                 [&](double ResultRow::*number) { return text::significant(row.*number); },
                 [&](std::optional<double> ResultRow::*number) {
                   return row.*number ? text::significant(*(row.*number)) : std::string();
                 },
                 [&](AnswerState ResultRow::*state) { return std::string(toString(row.*state)); },
                 [&](auto pose) { return poseCells(row.*pose); }},
      column.value);
}

std::string hypothesesHeader() {
  std::string header;
  for (const ResultColumn& column : resultColumns())
    for (const std::string& name : column.names()) header.append(header.empty() ? "" : ",").append(name);
  return header + "\n";
}

std::string hypothesesLines(const FrameResult& frame) {
  std::string lines;
  for (const ResultRow& row : frame.rows) {
    std::string line;
    for (const ResultColumn& column : resultColumns())
      line.append(&column == &resultColumns().front() ? "" : ",").append(cellsOf(column, row));
    lines += line + "\n";
  }
  return lines;
}

/** The upper triangle by rows; rotation x, y, z, then translation. */
template <class Visit>
void forEachOfTriangle(const Visit& visit) {
  static constexpr std::array<const char*, 6> kAxes = {"rx", "ry", "rz", "tx", "ty", "tz"};
  for (int i = 0; i < 6; ++i)
    for (int j = i; j < 6; ++j) visit(i, j, fmt::format("{}_{}", kAxes[i], kAxes[j]));
}

std::string covariancesHeader() {
  std::string header = "frame";
  forEachOfTriangle([&](int, int, const std::string& name) { header += "," + name; });
  return header + "\n";
}

std::string covarianceLine(const FrameResult& frame) {
  const ResultRow& row = frame.rows.front();
  if (row.rank != 1 || !row.T_w_c || !row.P_w_c) return {};
  std::string line = text::csvCell(row.frame);
  forEachOfTriangle([&](int i, int j, const std::string&) {
    line.append(",").append(text::significant((*row.P_w_c)(i, j)));
  });
  return line + '\n';
}

std::string sharesHeader() {
  std::string header = "frame";
  for (const auto& [name, share] : ViewShares::kNamed) header.append(",").append(name);
  return header + "\n";
}

std::string sharesLine(const FrameResult& frame) {
  const ResultRow& row = frame.rows.front();
  if (row.rank != 1 || !row.shares) return {};
  std::string line = text::csvCell(row.frame);
  for (const auto& [name, share] : ViewShares::kNamed)
    line.append(",").append(text::significant((*row.shares).*share));
  return line + '\n';
}

constexpr const char* kTimingHeader = "frame,segment_ms,features_ms,localize_ms,models\n";

std::string timingLine(const FrameResult& frame) {
  const TimingRow& t = frame.timing;
  std::string line = text::csvCell(t.frame);
  for (const double ms : {t.segment_ms, t.features_ms, t.localize_ms})
    line.append(",").append(text::decimals(ms, kTimeDecimals));
  return line + ',' + std::to_string(t.models) + '\n';
}

bool isOnTrajectory(const ResultRow& row) {
  return row.rank == 1 && row.T_w_c && row.state == AnswerState::sure;
}

/** Lines of poses by the part of the map in whose frame they are; the world's is empty. */
using PoseLines = std::map<std::string, std::string>;

PoseLines poseLines(const FrameResult& frame) {
  PoseLines lines;
  for (const ResultRow& row : frame.rows)
    if (isOnTrajectory(row)) lines[row.part] += tum::line({frame.stamp, *row.T_w_c});
  return lines;
}

/** Parts have arbitrary names: characters that are invalid in the name of a file become their codes. */
fs::path poseFile(const fs::path& folder, const std::string& part) {
  if (part.empty()) return folder / kPoses;
  constexpr std::size_t kLongest = 100;  // characters, which files of all systems may have
  std::string name;
  for (const char c : part.substr(0, kLongest)) {
    const bool is_plain = std::isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '-' || c == '_';
    name += is_plain ? std::string(1, c) : fmt::format("%{:02x}", static_cast<unsigned char>(c));
  }
  return folder / fmt::format("{}{}{}", kPosesOfPart, name, kPosesEnding);
}

/** Files of an earlier run, of parts that may not come again. */
void removePosesOfParts(const fs::path& folder) {
  const auto isOfPart = [](const fs::directory_entry& entry) {
    return entry.is_regular_file() && entry.path().filename().string().rfind(kPosesOfPart, 0) == 0 &&
           entry.path().extension() == kPosesEnding;
  };
  for (const fs::path& file : files::entriesOf(folder, isOfPart)) fs::remove(file);
}

Eigen::Isometry3d readPose(const csv::Table& table, const csv::Row& row, const PoseNames& names) {
  PoseColumns columns;
  for (std::size_t i = 0; i < columns.size(); ++i) columns[i] = table.real(row, names[i]);
  if (const char* fault = faultOf(columns, kQuaternionTolerance))
    table.fail(row, fmt::format("{} to {} {}", names.front(), names.back(), fault));
  return fromColumns(columns, kQuaternionTolerance);
}

std::optional<Eigen::Isometry3d> readPoseIfAny(const csv::Table& table, const csv::Row& row,
                                               const PoseNames& names) {
  const auto isEmpty = [&](const std::string& name) {
    return text::trimmed(table.string(row, name)).empty();
  };
  if (std::all_of(names.begin(), names.end(), isEmpty)) return {};
  return readPose(table, row, names);
}

AnswerState stateIn(const csv::Table& table, const csv::Row& row, const std::string& name) {
  const auto state = answerStateOf(table.string(row, name));
  if (!state) table.fail(row, name + " is not one of sure, doubtful, unknown");
  return *state;
}

double numberIn(const csv::Table& table, const csv::Row& row, const ResultColumn& column) {
  const double number = table.real(row, column.name);
  if (number < column.least || number > column.most)
    table.fail(row, std::isinf(column.most)
                        ? fmt::format("{} is negative", column.name)
                        : fmt::format("{} is not between {} and {}", column.name, column.least, column.most));
  return number;
}

void readColumn(const csv::Table& table, const csv::Row& row, const ResultColumn& column, ResultRow& into) {
  std::visit(
      Overloaded{[&](std::string ResultRow::*text) { into.*text = table.string(row, column.name); },
                 [&](int ResultRow::*count) { into.*count = table.count(row, column.name); },
                 [&](double ResultRow::*number) { into.*number = numberIn(table, row, column); },
                 [&](std::optional<double> ResultRow::*number) {
                   if (table.has(column.name) && !text::trimmed(table.string(row, column.name)).empty())
                     into.*number = numberIn(table, row, column);
                 },
                 [&](AnswerState ResultRow::*state) { into.*state = stateIn(table, row, column.name); },
                 [&](Eigen::Isometry3d ResultRow::*T) { into.*T = readPose(table, row, column.names()); },
                 [&](std::optional<Eigen::Isometry3d> ResultRow::*T) {
                   into.*T = readPoseIfAny(table, row, column.names());
                 }},
      column.value);
}

ResultRow readRow(const csv::Table& table, const csv::Row& row) {
  ResultRow result;
  for (const ResultColumn& column : resultColumns())  // the rank is among the first
    if (column.has_always || result.rank > 0) readColumn(table, row, column, result);
  if (result.rank == 0) result.state = AnswerState::unknown;
  return result;
}

csv::Table tableOf(const fs::path& path, const Remark& remark) {
  csv::Table table(path, remark != nullptr);
  if (table.isTorn()) remark(path.string() + ": its last line is torn, and left out");
  return table;
}

void ignore(const std::string&) {}

fs::path created(const fs::path& folder) {
  createFolders(folder);
  return folder;
}

}  // namespace

std::vector<std::string> ResultColumn::names() const {
  const bool is_pose = std::holds_alternative<Eigen::Isometry3d ResultRow::*>(value) ||
                       std::holds_alternative<std::optional<Eigen::Isometry3d> ResultRow::*>(value);
  if (!is_pose) return {name};
  std::vector<std::string> names;
  for (const std::string& in_world : kWorldPose) names.push_back(name[2] + in_world.substr(1));
  return names;
}

const std::vector<ResultColumn>& resultColumns() {
  using R = ResultRow;
  static const std::vector<ResultColumn> columns = {
      {"frame", &R::frame, "name of the image", "", true},
      {"rank", &R::rank, "1 = best; 0 = no pose", "", true},
      {"model", &R::model, "local model by which the pose was found"},
      {"probability", &R::probability, "of the pose, against all others and none", "", false, 0, 1},
      {"score", &R::score, "evidence that the probability comes from", "nats"},
      {"T_m_c", &R::T_m_c, "camera in the local model: position, quaternion x y z w", "m"},
      {"T_w_c", &R::T_w_c, "camera (x right, y down, z forward) in the world, if the map has poses", "m"},
      {"sd_rot_deg", &R::sd_rot_deg, "largest standard deviation of the orientation", "deg", false, 0},
      {"sd_trans_m", &R::sd_trans_m, "largest standard deviation of the position", "m", false, 0},
      {"reason", &R::reason, "reason of a missing pose, or a remark on it", "", true},
      {"state", &R::state, "of the image: sure, doubtful or unknown", "", true},
      {"part", &R::part, "part of the map in whose frame the poses are; empty: the world"},
      {"not_in_map", &R::not_in_map, "probability that the map lacks the place", "", true, 0, 1}};
  return columns;
}

/** The lines of each file for one frame or for several. */
struct ResultsWriter::Text {
  std::string timing, covariances, shares, hypotheses;
  PoseLines poses;

  Text() = default;
  explicit Text(const FrameResult& frame)
      : timing(timingLine(frame)),
        covariances(covarianceLine(frame)),
        shares(sharesLine(frame)),
        hypotheses(hypothesesLines(frame)),
        poses(poseLines(frame)) {}
  explicit Text(const std::vector<FrameResult>& frames) {
    for (const FrameResult& frame : frames) add(Text(frame));
  }
  /** As it is in a folder. */
  Text(const fs::path& folder, const std::vector<ResultFrame>& kept) {
    if (kept.empty()) return;
    std::map<std::string, Text> frames = readFrames(folder);
    for (const auto& [name, stamp] : kept) {
      Text& frame = frames[name];
      if (frame.timing.empty() || frame.hypotheses.empty()) continue;
      for (auto& [part, lines] : frame.poses)
        lines = text::decimals(stamp, tum::kStampDecimals) + lines + "\n";
      add(frame);
    }
  }

private:
  /** The lines of each frame; those of the trajectory lack their stamps. */
  static std::map<std::string, Text> readFrames(const fs::path& folder) {
    std::map<std::string, Text> frames;
    const auto readLines = [&](const char* file, std::string Text::*line) {
      const csv::Table table = tableOf(folder / file, ignore);
      for (const csv::Row& row : table.rows()) frames[table.string(row, "frame")].*line = row.text;
    };
    readLines(kTiming, &Text::timing);
    readLines(kCovariances, &Text::covariances);
    if (fs::exists(folder / kShares)) readLines(kShares, &Text::shares);  // not in those of older versions
    const csv::Table hypotheses = tableOf(folder / kHypotheses, ignore);
    for (const csv::Row& row : hypotheses.rows()) {
      Text& frame = frames[hypotheses.string(row, "frame")];
      frame.hypotheses += row.text;
      const ResultRow read = readRow(hypotheses, row);
      if (!isOnTrajectory(read)) continue;
      for (const std::string& name : kWorldPose) frame.poses[read.part] += " " + hypotheses.string(row, name);
    }
    return frames;
  }

  void add(const Text& other) {
    timing += other.timing;
    for (const auto& [part, lines] : other.poses) poses[part] += lines;
    covariances += other.covariances;
    shares += other.shares;
    hypotheses += other.hypotheses;
  }
};

void writeResults(const fs::path& folder, const std::vector<FrameResult>& frames,
                  const std::string& params_ini) {
  for (const FrameResult& frame : frames) requireWritable(frame);
  ResultsWriter(folder, params_ini, ResultsWriter::Text(frames));
}

ResultsWriter::ResultsWriter(const fs::path& folder, const std::string& params_ini,
                             const std::vector<ResultFrame>& kept)
    : ResultsWriter(folder, params_ini, Text(folder, kept)) {}

ResultsWriter::ResultsWriter(const fs::path& folder, const std::string& params_ini, const Text& begin)
    : folder_(created(folder)),
      timing_(folder / kTiming, kTimingHeader + begin.timing),
      covariances_(folder / kCovariances, covariancesHeader() + begin.covariances),
      shares_(folder / kShares, sharesHeader() + begin.shares),
      hypotheses_(folder / kHypotheses, hypothesesHeader() + begin.hypotheses) {
  removePosesOfParts(folder);
  addPoses("", {});  // poses in the world, even without any
  for (const auto& [part, lines] : begin.poses) addPoses(part, lines);
  writeTextAtomically(folder / kParams, [&](std::ostream& out) { out << params_ini; });
}

/** To the file of a part, which its first pose makes. */
void ResultsWriter::addPoses(const std::string& part, const std::string& lines) {
  const fs::path file = poseFile(folder_, part);
  const auto known = poses_.find(file.string());
  if (known != poses_.end())
    known->second.append(lines);
  else
    poses_.try_emplace(file.string(), file, tum::kHeader + lines);
}

void ResultsWriter::append(const FrameResult& frame) {
  requireWritable(frame);
  const Text text(frame);
  hypotheses_.append(text.hypotheses);
  covariances_.append(text.covariances);
  shares_.append(text.shares);
  for (const auto& [part, lines] : text.poses) addPoses(part, lines);
  timing_.append(text.timing);  // with which the frame counts
}

bool isResultsFolder(const fs::path& folder) { return files::isThere(folder / kHypotheses); }

std::vector<ResultRow> readHypotheses(const fs::path& folder, const Remark& remark) {
  const csv::Table table = tableOf(folder / kHypotheses, remark);
  std::vector<ResultRow> rows;
  for (const csv::Row& row : table.rows()) rows.push_back(readRow(table, row));
  return rows;
}

std::map<std::string, Matrix6d> readCovariances(const fs::path& folder, const Remark& remark) {
  std::map<std::string, Matrix6d> covariances;
  if (!fs::exists(folder / kCovariances)) return covariances;
  const csv::Table table = tableOf(folder / kCovariances, remark);
  for (const csv::Row& row : table.rows()) {
    Matrix6d P;
    forEachOfTriangle(
        [&](int i, int j, const std::string& name) { P(i, j) = P(j, i) = table.real(row, name); });
    if ((P.diagonal().array() < 0).any()) table.fail(row, "a variance is negative");
    covariances[table.string(row, "frame")] = P;
  }
  return covariances;
}

std::map<std::string, ViewShares> readShares(const fs::path& folder, const Remark& remark) {
  std::map<std::string, ViewShares> all;
  if (!fs::exists(folder / kShares)) return all;
  const csv::Table table = tableOf(folder / kShares, remark);
  for (const csv::Row& row : table.rows())
    for (const auto& [name, share] : ViewShares::kNamed) {
      const double value = all[table.string(row, "frame")].*share = table.real(row, name);
      if (value < 0 || value > 1) table.fail(row, fmt::format("{} is not between 0 and 1", name));
    }
  return all;
}

std::vector<TimingRow> readTiming(const fs::path& folder, const Remark& remark) {
  const csv::Table table = tableOf(folder / kTiming, remark);
  std::vector<TimingRow> rows;
  for (const csv::Row& row : table.rows())
    rows.push_back({table.string(row, "frame"), table.real(row, "segment_ms"), table.real(row, "features_ms"),
                    table.real(row, "localize_ms"), table.count(row, "models")});
  return rows;
}

std::map<std::string, FrameResult> readResults(const fs::path& folder) {
  std::map<std::string, FrameResult> frames;
  for (TimingRow& timing : readTiming(folder, ignore)) frames[timing.frame].timing = std::move(timing);
  for (ResultRow& row : readHypotheses(folder, ignore))
    if (const auto found = frames.find(row.frame); found != frames.end())
      found->second.rows.push_back(std::move(row));
  for (auto frame = frames.begin(); frame != frames.end();)
    frame = frame->second.rows.empty() ? frames.erase(frame) : std::next(frame);
  for (const auto& [name, covariance] : readCovariances(folder, ignore))
    if (const auto found = frames.find(name); found != frames.end())
      found->second.rows.front().P_w_c = covariance;
  for (const auto& [name, shares] : readShares(folder, ignore))
    if (const auto found = frames.find(name); found != frames.end())
      found->second.rows.front().shares = shares;
  return frames;
}

void writeStarts(const fs::path& folder, const std::vector<StartAnswer>& answers) {
  writeTextAtomically(folder / kStarts, [&](std::ostream& out) {
    out << "start,frame,state,probability";
    for (const std::string& name : kWorldPose) out << ',' << name;
    out << '\n';
    for (const StartAnswer& answer : answers)
      out << text::csvCell(answer.start) << ',' << text::csvCell(answer.frame) << ','
          << toString(answer.state) << ',' << text::significant(answer.probability) << ','
          << poseCells(answer.T_w_c) << '\n';
  });
}

std::vector<StartAnswer> readStarts(const fs::path& folder, const Remark& remark) {
  std::vector<StartAnswer> answers;
  if (!fs::exists(folder / kStarts)) return answers;
  const csv::Table table = tableOf(folder / kStarts, remark);
  for (const csv::Row& row : table.rows()) {
    StartAnswer answer{table.string(row, "start"), table.string(row, "frame"), {}, 0, {}};
    answer.state = stateIn(table, row, "state");
    answer.probability = table.real(row, "probability");
    answer.T_w_c = readPoseIfAny(table, row, kWorldPose);
    answers.push_back(std::move(answer));
  }
  return answers;
}

}  // namespace facetloc
