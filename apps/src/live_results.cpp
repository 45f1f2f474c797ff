// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/apps/live_results.h>
#include <facetloc/apps/localization_report.h>
#include <facetloc/apps/text.h>

namespace facetloc {
namespace {

std::vector<ResultRow> rowsOf(const LiveResult& result, const Map* map) {
  const std::string& frame = result.image.name;
  if (!result.tracked || !map) return {noHypothesis(frame, "segmented without a map")};
  const Hypothesis* match = result.match();
  if (!result.isLocalized() || !match)
    return {noHypothesis(frame, result.state() + (result.reason().empty() ? "" : ": " + result.reason()))};
  return resultRows(frame, {{*match}, {}}, *map, 1);
}

}  // namespace

LiveResults::LiveResults(const std::filesystem::path& folder, const std::string& params_ini,
                         std::shared_ptr<const Map> map)
    : map_(std::move(map)),
      results_(folder, params_ini),
      states_(folder / "states.csv", "frame,stamp,state,reason,received,dropped,age_ms\n") {}

void LiveResults::append(const LiveResult& result) {
  FrameResult frame;
  frame.stamp = result.stamp;
  frame.rows = rowsOf(result, map_.get());
  frame.timing = {result.image.name, result.segment_ms, result.features_ms, result.localize_ms,
                  map_ ? static_cast<int>(map_->models.size()) : 0};
  results_.append(frame);
  states_.append(result.image.name + "," + fixed(result.stamp, 6) + "," + result.state() + "," +
                 csvCell(result.reason()) + "," + std::to_string(result.received) + "," +
                 std::to_string(result.dropped) + "," + fixed(result.age_ms, 3) + "\n");
}

}  // namespace facetloc
