// SPDX-License-Identifier: BSD-3-Clause
#include "csv.h"
#include "pose_columns.h"
#include "tum_line.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/results.h>
#include <facetloc/io/text.h>
#include <facetloc/io/trajectory.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>

namespace facetloc {
namespace {

constexpr const char* kHypotheses = "hypotheses.csv";
constexpr const char* kTiming = "timing.csv";
constexpr const char* kPoses = "poses_tum.txt";
constexpr const char* kCovariances = "covariances.csv";
constexpr const char* kStarts = "starts.csv";
constexpr const char* kParams = "params.ini";
constexpr std::array<const char*, 7> kModelPose = {"m_tx", "m_ty", "m_tz", "m_qx", "m_qy", "m_qz", "m_qw"};
constexpr std::array<const char*, 7> kWorldPose = {"w_tx", "w_ty", "w_tz", "w_qx", "w_qy", "w_qz", "w_qw"};
constexpr double kQuaternionTolerance = 1e-3;  // of |q|^2 as read
constexpr int kTimeDecimals = 3;               // of milliseconds

void requireWritable(const FrameResult& frame) {
  if (frame.rows.empty()) throw std::invalid_argument("a frame of the results has no row");
  for (const ResultRow& row : frame.rows) {
    const bool finite = std::isfinite(row.probability) && std::isfinite(row.score) &&
                        std::isfinite(row.sd_rot_deg) && std::isfinite(row.sd_trans_m) &&
                        row.T_m_c.matrix().allFinite() && (!row.T_w_c || row.T_w_c->matrix().allFinite()) &&
                        (!row.P_w_c || row.P_w_c->allFinite());
    if (row.rank < 0 || !finite)
      throw std::invalid_argument("results of frame " + row.frame + " are not finite");
  }
}

std::string poseCells(const std::optional<Eigen::Isometry3d>& T) {
  if (!T) return std::string(kWorldPose.size() - 1, ',');
  std::string cells;
  for (const double value : toColumns(*T))
    cells.append(cells.empty() ? "" : ",").append(text::significant(value));
  return cells;
}

/** What a row with a hypothesis says between its rank and its reason. */
std::string hypothesisCells(const ResultRow& row) {
  return text::csvCell(row.model) + ',' + text::significant(row.probability) + ',' +
         text::significant(row.score) + ',' + poseCells(row.T_m_c) + ',' + poseCells(row.T_w_c) + ',' +
         text::significant(row.sd_rot_deg) + ',' + text::significant(row.sd_trans_m);
}

constexpr std::size_t kHypothesisCells = 3 + kModelPose.size() + kWorldPose.size() + 2;

std::string hypothesesHeader() {
  std::string header = "frame,rank,model,probability,score";
  for (const auto& names : {kModelPose, kWorldPose})
    for (const char* name : names) header.append(",").append(name);
  return header + ",sd_rot_deg,sd_trans_m,reason,state,part\n";
}

std::string hypothesesLines(const FrameResult& frame) {
  static const std::string no_hypothesis(kHypothesisCells - 1, ',');
  std::string lines;
  for (const ResultRow& row : frame.rows)
    lines += text::csvCell(row.frame) + ',' + std::to_string(row.rank) + ',' +
             (row.rank ? hypothesisCells(row) : no_hypothesis) + ',' + text::csvCell(row.reason) + ',' +
             toString(row.state) + ',' + text::csvCell(row.part) + '\n';
  return lines;
}

/** The upper triangle by rows; rotation x, y, z, then translation. */
template <class Visit>
void forEachOfTriangle(const Visit& visit) {
  static constexpr std::array<const char*, 6> kAxes = {"rx", "ry", "rz", "tx", "ty", "tz"};
  for (int i = 0; i < 6; ++i)
    for (int j = i; j < 6; ++j) visit(i, j, std::string(kAxes[i]) + "_" + kAxes[j]);
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

constexpr const char* kTimingHeader = "frame,segment_ms,features_ms,localize_ms,models\n";

std::string timingLine(const FrameResult& frame) {
  const TimingRow& t = frame.timing;
  std::string line = text::csvCell(t.frame);
  for (const double ms : {t.segment_ms, t.features_ms, t.localize_ms})
    line.append(",").append(text::decimals(ms, kTimeDecimals));
  return line + ',' + std::to_string(t.models) + '\n';
}

std::string poseLines(const FrameResult& frame) {
  std::string lines;
  for (const ResultRow& row : frame.rows)
    if (row.rank == 1 && row.T_w_c && row.part.empty() && row.state == AnswerState::sure)
      lines += tum::line({frame.stamp, *row.T_w_c});
  return lines;
}

/** What a file holds of all frames. */
template <class LinesOf>
void writeAll(const std::filesystem::path& path, const std::string& header,
              const std::vector<FrameResult>& frames, const LinesOf& linesOf) {
  writeTextAtomically(path, [&](std::ostream& out) {
    out << header;
    for (const FrameResult& frame : frames) out << linesOf(frame);
  });
}

Eigen::Isometry3d readPose(const csv::Table& table, const csv::Row& row,
                           const std::array<const char*, 7>& names) {
  PoseColumns columns;
  for (std::size_t i = 0; i < names.size(); ++i) columns[i] = table.real(row, names[i]);
  if (const char* fault = faultOf(columns, kQuaternionTolerance))
    table.fail(row, std::string(names[0]) + " to " + names[6] + " " + fault);
  return *fromColumns(columns, kQuaternionTolerance);
}

bool allEmpty(const csv::Table& table, const csv::Row& row, const std::array<const char*, 7>& names) {
  return std::all_of(names.begin(), names.end(),
                     [&](const char* name) { return text::trimmed(table.string(row, name)).empty(); });
}

std::optional<AnswerState> stateIn(const csv::Table& table, const csv::Row& row) {
  if (!table.hasColumn("state")) return {};
  const auto state = answerStateOf(table.string(row, "state"));
  if (!state) table.fail(row, "state is none of sure, doubtful, unknown");
  return state;
}

ResultRow readRow(const csv::Table& table, const csv::Row& row) {
  ResultRow result;
  result.frame = table.string(row, "frame");
  result.rank = table.count(row, "rank");
  result.reason = table.string(row, "reason");
  const std::optional<AnswerState> state = stateIn(table, row);
  if (result.rank == 0) return result;
  result.state = state.value_or(AnswerState::doubtful);
  result.model = table.string(row, "model");
  if (table.hasColumn("part")) result.part = table.string(row, "part");
  result.probability = table.real(row, "probability");
  if (!plausible::isProbability(result.probability)) table.fail(row, "probability is not between 0 and 1");
  result.score = table.real(row, "score");
  result.T_m_c = readPose(table, row, kModelPose);
  if (!allEmpty(table, row, kWorldPose)) result.T_w_c = readPose(table, row, kWorldPose);
  result.sd_rot_deg = table.real(row, "sd_rot_deg");
  result.sd_trans_m = table.real(row, "sd_trans_m");
  if (result.sd_rot_deg < 0 || result.sd_trans_m < 0) table.fail(row, "a standard deviation is negative");
  return result;
}

std::filesystem::path created(const std::filesystem::path& folder) {
  createFolders(folder);
  return folder;
}

}  // namespace

void writeResults(const std::filesystem::path& folder, const std::vector<FrameResult>& frames,
                  const std::string& params_ini) {
  for (const FrameResult& frame : frames) requireWritable(frame);
  createFolders(folder);
  writeTextAtomically(folder / kParams, [&](std::ostream& out) { out << params_ini; });
  writeAll(folder / kTiming, kTimingHeader, frames, timingLine);
  writeAll(folder / kPoses, tum::kHeader, frames, poseLines);
  writeAll(folder / kCovariances, covariancesHeader(), frames, covarianceLine);
  writeAll(folder / kHypotheses, hypothesesHeader(), frames, hypothesesLines);
}

ResultsWriter::ResultsWriter(const std::filesystem::path& folder, const std::string& params_ini)
    : timing_(created(folder) / kTiming, kTimingHeader),
      poses_(folder / kPoses, tum::kHeader),
      covariances_(folder / kCovariances, covariancesHeader()),
      hypotheses_(folder / kHypotheses, hypothesesHeader()) {
  writeTextAtomically(folder / kParams, [&](std::ostream& out) { out << params_ini; });
}

void ResultsWriter::append(const FrameResult& frame) {
  requireWritable(frame);
  timing_.append(timingLine(frame));
  poses_.append(poseLines(frame));
  covariances_.append(covarianceLine(frame));
  hypotheses_.append(hypothesesLines(frame));
}

bool isResultsFolder(const std::filesystem::path& folder) {
  std::error_code ignored;
  return std::filesystem::exists(folder / kHypotheses, ignored);
}

namespace {

csv::Table tableOf(const std::filesystem::path& path, const Remark& remark) {
  csv::Table table(path, remark != nullptr);
  if (table.isTorn()) remark(path.string() + ": its last line is torn, and left out");
  return table;
}

/** Of results that were written before there were states. */
void addStates(std::vector<ResultRow>& rows) {
  std::map<std::string, AnswerState> states;
  for (const ResultRow& row : rows)
    if (row.rank == 1 && row.probability >= kMinProbability) states[row.frame] = AnswerState::sure;
  for (ResultRow& row : rows)
    if (row.rank > 0 && states.count(row.frame)) row.state = AnswerState::sure;
}

}  // namespace

std::vector<ResultRow> readHypotheses(const std::filesystem::path& folder, const Remark& remark) {
  const csv::Table table = tableOf(folder / kHypotheses, remark);
  std::vector<ResultRow> rows;
  for (const csv::Row& row : table.rows()) rows.push_back(readRow(table, row));
  if (!table.hasColumn("state")) addStates(rows);
  return rows;
}

std::map<std::string, Matrix6d> readCovariances(const std::filesystem::path& folder, const Remark& remark) {
  std::map<std::string, Matrix6d> covariances;
  if (!std::filesystem::exists(folder / kCovariances)) return covariances;
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

std::vector<TimingRow> readTiming(const std::filesystem::path& folder, const Remark& remark) {
  const csv::Table table = tableOf(folder / kTiming, remark);
  std::vector<TimingRow> rows;
  for (const csv::Row& row : table.rows())
    rows.push_back({table.string(row, "frame"), table.real(row, "segment_ms"), table.real(row, "features_ms"),
                    table.real(row, "localize_ms"), table.count(row, "models")});
  return rows;
}

void writeStarts(const std::filesystem::path& folder, const std::vector<StartAnswer>& answers) {
  writeTextAtomically(folder / kStarts, [&](std::ostream& out) {
    out << "start,frame,state,probability";
    for (const char* name : kWorldPose) out << ',' << name;
    out << '\n';
    for (const StartAnswer& answer : answers)
      out << text::csvCell(answer.start) << ',' << text::csvCell(answer.frame) << ','
          << toString(answer.state) << ',' << text::significant(answer.probability) << ','
          << poseCells(answer.T_w_c) << '\n';
  });
}

std::vector<StartAnswer> readStarts(const std::filesystem::path& folder, const Remark& remark) {
  std::vector<StartAnswer> answers;
  if (!std::filesystem::exists(folder / kStarts)) return answers;
  const csv::Table table = tableOf(folder / kStarts, remark);
  for (const csv::Row& row : table.rows()) {
    StartAnswer answer{table.string(row, "start"), table.string(row, "frame"), {}, 0, {}};
    answer.state = stateIn(table, row).value_or(AnswerState::unknown);
    answer.probability = table.real(row, "probability");
    if (!allEmpty(table, row, kWorldPose)) answer.T_w_c = readPose(table, row, kWorldPose);
    answers.push_back(std::move(answer));
  }
  return answers;
}

}  // namespace facetloc
