// SPDX-License-Identifier: BSD-3-Clause
#include "outputs/localization_report.h"

#include "base/text.h"
#include "cli/text.h"

#include <fmt/core.h>

namespace facetloc {
namespace {

ResultRow resultRow(const std::string& frame, int rank, const Hypothesis& h, const Map& map) {
  ResultRow row;
  row.frame = frame;
  row.rank = rank;
  row.model = map.models[h.model].name;
  row.probability = h.probability;
  row.score = h.score;
  row.T_m_c = h.T_m_c.T;
  row.T_w_c = h.T_w_c;
  row.part = map.partOf(h.model);
  row.sd_rot_deg = largestRotationStd(h.T_m_c.P) / kDegree;
  row.sd_trans_m = largestTranslationStd(h.T_m_c.P);
  if (h.depth_assisted) row.reason = "depth-assisted";
  if (const auto& T_w_m = map.models[h.model].T_w_m; rank == 1 && T_w_m && h.T_w_c)
    row.P_w_c = (*T_w_m * h.T_m_c).P;
  return row;
}

std::string vectorText(const Eigen::Vector3d& v, int decimals) {
  // Adding zero makes -0 positive.
  return fmt::format("{0:.{3}f} {1:.{3}f} {2:.{3}f}", v.x() + 0.0, v.y() + 0.0, v.z() + 0.0, decimals);
}

}  // namespace

std::vector<ResultRow> resultRows(const std::string& frame, const Localization& answer, const Map& map,
                                  int max_hypotheses) {
  if (answer.hypotheses.empty()) return {noHypothesis(frame, answer.reason)};
  std::vector<ResultRow> rows;
  for (const Hypothesis& h : answer.hypotheses) {
    if (static_cast<int>(rows.size()) == max_hypotheses) break;
    rows.push_back(resultRow(frame, static_cast<int>(rows.size()) + 1, h, map));
    rows.back().state = answer.state;
    rows.back().not_in_map = answer.not_in_map;
  }
  std::string& reason = rows.front().reason;
  if (!reason.empty() && !answer.reason.empty()) reason += "; ";
  reason += answer.reason;
  return rows;
}

void addMinProbability(CommandLine& line, double& min_probability) {
  line.addOption("min-probability", min_probability, "P",
                 "Minimum probability of a sure answer. A calibrated map has its own default.");
  line.addCheck([&min_probability] {
    if (!(min_probability > 0 && min_probability <= 1))
      throw UsageError("min-probability must be above 0 and at most 1");
  });
}

void StateCounts::add(AnswerState state) {
  ++(state == AnswerState::sure ? sure : state == AnswerState::doubtful ? doubtful : unknown);
}

std::string toString(const StateCounts& counts) {
  return fmt::format("{}: {} sure, {} doubtful, {} unknown",
                     counted(static_cast<std::size_t>(counts.all()), "image"), counts.sure, counts.doubtful,
                     counts.unknown);
}

ResultRow noHypothesis(const std::string& frame, const std::string& reason) {
  ResultRow row;
  row.frame = frame;
  row.reason = reason;
  row.not_in_map = 1;
  return row;
}

void printPoses(std::ostream& out, const std::vector<ResultRow>& rows) {
  TextTable table({"rank", "probability", "score", "translation [m]", "rotation vector [deg]", "angle [deg]",
                   "std [m]", "std [deg]", "remarks"});
  table.setWordsLast();
  for (const ResultRow& row : rows) {
    const Eigen::Vector3d rotation = logSO3(row.T_m_c.linear()) / kDegree;
    table.add({std::to_string(row.rank), text::decimals(row.probability, 4), text::decimals(row.score, 1),
               vectorText(row.T_m_c.translation(), 3), vectorText(rotation, 2),
               text::decimals(rotation.norm(), 2), text::decimals(row.sd_trans_m, 3),
               text::decimals(row.sd_rot_deg, 2), row.reason});
  }
  out << table;
}

}  // namespace facetloc
