// SPDX-License-Identifier: BSD-3-Clause
#include "live/live_results.h"

#include "base/text.h"
#include "outputs/localization_report.h"

#include <fmt/format.h>
#include <limits>
#include <optional>

namespace facetloc {
namespace {

/** The nearest model with a pose in the main part; empty without such a model. */
std::optional<int> nearestModel(const Map& map, const Eigen::Vector3d& place) {
  std::optional<int> nearest;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < map.models.size(); ++i) {
    const auto& T_w_m = map.models[i].T_w_m;
    const bool counts = T_w_m && map.models[i].part == 0;
    const double squared = counts ? (T_w_m->translation() - place).squaredNorm() : least;
    if (squared < least) least = squared, nearest = static_cast<int>(i);
  }
  return nearest;
}

ResultRow rowOf(const std::string& frame, const Hypothesis& best, const Map& map, double min_probability) {
  Localization answer;
  answer.hypotheses = {best};
  answer.decide(min_probability);
  return resultRows(frame, answer, map, 1).front();
}

/** Row of the camera that makes the map. */
ResultRow rowOf(const std::string& frame, const PoseWithCovariance& pose, const Map& map,
                double min_probability) {
  const auto nearest = nearestModel(map, pose.T.translation());
  if (!nearest) return noHypothesis(frame, "the map has no local model yet");
  Hypothesis carried;
  carried.model = *nearest;
  carried.T_w_c = pose.T;
  carried.T_m_c = map.models[*nearest].T_w_m->inverse() * pose;
  carried.probability = 1;
  return rowOf(frame, carried, map, min_probability);
}

ResultRow rowOf(const LiveResult& result, const Map* map, double min_probability) {
  const std::string& frame = result.image.name;
  if (!result.mapped && (!result.answer || !map)) return noHypothesis(frame, "segmented without a map");
  if (!result.isLocalized())
    return noHypothesis(frame, result.state() + (result.reason().empty() ? "" : ": " + result.reason()));
  if (result.mapped) return rowOf(frame, *result.pose(), *result.mapped->map, min_probability);
  ResultRow row = rowOf(frame, result.answer->hypotheses.front(), *map, min_probability);
  row.state = AnswerState::sure;
  if (!result.match()) row.reason = "carried on: no local model shows what is in view";
  return row;
}

OutputLock lockOf(const std::filesystem::path& folder) {
  createFolders(folder);
  return OutputLock::ofFolder(folder);
}

}  // namespace

FrameResult frameResult(const LiveResult& result, const Map* map, double min_probability) {
  FrameResult frame;
  frame.stamp = result.stamp;
  frame.rows = {rowOf(result, map, min_probability)};
  if (result.answer) frame.rows.front().not_in_map = result.answer->not_in_map;
  if (result.answer && frame.rows.front().rank > 0) frame.rows.front().shares = result.answer->shares;
  if (result.answer) frame.rows.front().next_look = result.answer->next_look;
  frame.timing = {result.image.name, result.segment_ms, result.features_ms, result.localize_ms,
                  static_cast<int>(result.mapped ? result.mapped->map->models.size()
                                   : map         ? map->models.size()
                                                 : 0)};
  return frame;
}

LiveResults::LiveResults(const std::filesystem::path& folder, const std::string& params_ini)
    : lock_(lockOf(folder)),
      results_(folder, params_ini),
      states_(folder / "states.csv", "frame,stamp,state,reason,received,dropped,age_ms\n") {}

void LiveResults::append(const LiveResult& result, const FrameResult& row) {
  results_.append(row);
  states_.append(fmt::format("{},{},{},{},{},{},{:.3f}\n", result.image.name, text::decimals(result.stamp, 6),
                             result.state(), text::csvCell(result.reason()), result.received, result.dropped,
                             result.age_ms));
}

}  // namespace facetloc
