// SPDX-License-Identifier: BSD-3-Clause
#include "live/live_results.h"

#include "tools/localization_report.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/text.h>

#include <limits>
#include <optional>

namespace facetloc {

namespace {

/** Of the models of a part with a pose; nothing if there is none. */
std::optional<int> nearestModel(const Map& map, int part, const Eigen::Vector3d& place) {
  std::optional<int> nearest;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < map.models.size(); ++i) {
    const auto& T_w_m = map.models[i].T_w_m;
    const bool counts = T_w_m && map.models[i].part == part;
    const double squared = counts ? (T_w_m->translation() - place).squaredNorm() : least;
    if (squared < least) least = squared, nearest = static_cast<int>(i);
  }
  return nearest;
}

OutputLock lockOf(const std::filesystem::path& folder) {
  createFolders(folder);
  return OutputLock::ofFolder(folder);
}

}  // namespace

LiveResults::LiveResults(const std::filesystem::path& folder, const std::string& params_ini,
                         std::shared_ptr<const Map> map, double min_probability)
    : map_(std::move(map)),
      min_probability_(min_probability),
      lock_(lockOf(folder)),
      results_(folder, params_ini),
      states_(folder / "states.csv", "frame,stamp,state,reason,received,dropped,age_ms\n") {}

ResultRow LiveResults::rowOf(const std::string& frame, const Hypothesis& best, const Map& map) const {
  Localization answer;
  answer.hypotheses = {best};
  return resultRows(frame, answer, map, 1, min_probability_).front();
}

/** Of a pose that is not that beside a local model of its view. */
ResultRow LiveResults::rowOf(const std::string& frame, const PoseWithCovariance& pose, const Map& map,
                             int part, double probability) const {
  const auto nearest = nearestModel(map, part, pose.T.translation());
  if (!nearest) return noHypothesis(frame, "the map has no local model yet");
  Hypothesis carried;
  carried.part = part;
  carried.model = *nearest;
  carried.T_w_c = pose.T;
  carried.T_m_c = map.models[*nearest].T_w_m->inverse() * pose;
  carried.probability = probability;
  return rowOf(frame, carried, map);
}

ResultRow LiveResults::rowOf(const LiveResult& result) const {
  const std::string& frame = result.image.name;
  if (!result.mapped && (!result.tracked || !map_)) return noHypothesis(frame, "segmented without a map");
  if (!result.isLocalized())
    return noHypothesis(frame, result.state() + (result.reason().empty() ? "" : ": " + result.reason()));
  if (result.mapped) return rowOf(frame, *result.pose(), *result.mapped->map, 0, 1);
  if (const Hypothesis* match = result.match()) return rowOf(frame, *match, *map_);

  // The camera's own views carry the pose where no local model shows anything of the place.
  ResultRow row = rowOf(frame, *result.pose(), *map_, result.tracked->part, result.tracked->probability);
  row.reason = "carried on: no local model shows what is in view";
  return row;
}

void LiveResults::append(const LiveResult& result) {
  FrameResult frame;
  frame.stamp = result.stamp;
  frame.rows = {rowOf(result)};
  frame.timing = {result.image.name, result.segment_ms, result.features_ms, result.localize_ms,
                  static_cast<int>(result.mapped ? result.mapped->map->models.size()
                                   : map_        ? map_->models.size()
                                                 : 0)};
  results_.append(frame);
  states_.append(result.image.name + "," + text::decimals(result.stamp, 6) + "," + result.state() + "," +
                 text::csvCell(result.reason()) + "," + std::to_string(result.received) + "," +
                 std::to_string(result.dropped) + "," + text::decimals(result.age_ms, 3) + "\n");
}

}  // namespace facetloc
