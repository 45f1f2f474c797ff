// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/map_ambiguity.h"
#include "sessions/parallel_stage.h"

#include <facetloc/features/map_parts.h>
#include <facetloc/mapping/map_making.h>

namespace facetloc {

using namespace internal;

namespace {

AliasScores findAliases(const std::shared_ptr<const Map>& map, const MapCompletion& how) {
  AliasScores scores(map->models.size());
  const std::vector<int> models = viewsToAsk(*map);
  if (models.empty()) return scores;
  const GlobalLocalization localization(map);
  ParallelStage(MapProgress::Stage::ambiguity, models.size(), how.threads, how.progress)
      .run([&](std::size_t i) {
        if (const auto wrong = wrongPlace(localization, models[i])) scores[models[i]] = wrong->score;
      });
  return scores;
}

}  // namespace

std::optional<FoundMounting> completeMap(MapSink& sink, const MapCompletion& how) {
  const std::shared_ptr<Map> map = sink.map();
  std::optional<FoundMounting> found;
  if (how.mounting && !map->camera.mounting) found = findMounting(*map);
  if (found) {
    map->camera.mounting = found->mounting;
    placeByLinks(*map);  // up is known now
    sink.setMounting(map->camera, *found);
  }
  sink.setPlaceIndex(*map);
  if (map->ambiguity) return found;
  const AliasScores scores = findAliases(map, how);
  setAmbiguity(scores, *map);
  if (map->ambiguity) sink.setAmbiguity(*map->ambiguity, scores);
  return found;
}

}  // namespace facetloc
