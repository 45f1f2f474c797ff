// SPDX-License-Identifier: BSD-3-Clause
#include "live/live_results.h"

#include "tools/localization_report.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/text.h>

#include <limits>

namespace facetloc {

namespace {

/** Of the models of a part with a pose, of which there is one where a camera is tracked. */
int nearestModel(const Map& map, int part, const Eigen::Vector3d& place) {
  int nearest = 0;
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

ResultRow LiveResults::rowOf(const std::string& frame, const Hypothesis& best) const {
  Localization answer;
  answer.hypotheses = {best};
  return resultRows(frame, answer, *map_, 1, min_probability_).front();
}

ResultRow LiveResults::rowOf(const LiveResult& result) const {
  const std::string& frame = result.image.name;
  if (!result.tracked || !map_) return noHypothesis(frame, "segmented without a map");
  if (!result.isLocalized())
    return noHypothesis(frame, result.state() + (result.reason().empty() ? "" : ": " + result.reason()));
  if (const Hypothesis* match = result.match()) return rowOf(frame, *match);

  // The camera's own views carry the pose where no local model shows anything of the place.
  const PoseWithCovariance& pose = *result.pose();
  Hypothesis carried;
  carried.part = result.tracked->part;
  carried.model = nearestModel(*map_, carried.part, pose.T.translation());
  carried.T_w_c = pose.T;
  carried.T_m_c = map_->models[carried.model].T_w_m->inverse() * pose;
  carried.probability = result.tracked->probability;
  ResultRow row = rowOf(frame, carried);
  row.reason = "carried on: no local model shows what is in view";
  return row;
}

void LiveResults::append(const LiveResult& result) {
  FrameResult frame;
  frame.stamp = result.stamp;
  frame.rows = {rowOf(result)};
  frame.timing = {result.image.name, result.segment_ms, result.features_ms, result.localize_ms,
                  map_ ? static_cast<int>(map_->models.size()) : 0};
  results_.append(frame);
  states_.append(result.image.name + "," + text::decimals(result.stamp, 6) + "," + result.state() + "," +
                 text::csvCell(result.reason()) + "," + std::to_string(result.received) + "," +
                 std::to_string(result.dropped) + "," + text::decimals(result.age_ms, 3) + "\n");
}

}  // namespace facetloc
