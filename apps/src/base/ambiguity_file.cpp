// SPDX-License-Identifier: BSD-3-Clause
#include "base/ambiguity_file.h"

#include "base/batch.h"

#include <facetloc/io/map_database.h>
#include <facetloc/mapping/map_ambiguity.h>

namespace facetloc {

void writeAmbiguity(const std::filesystem::path& path, int threads, const Console& console) {
  const auto map = std::make_shared<const Map>(openMap(path));
  if (map->ambiguity) return;
  const std::vector<int> models = viewsToAsk(*map);
  std::vector<std::optional<Hypothesis>> wrong(models.size());
  if (!models.empty()) {
    const GlobalLocalization localization(map);
    Batch(threads, models.size(), console)
        .run([&](std::size_t i) { return map->models[models[i]].name; },
             [&](std::size_t i, int) { wrong[i] = wrongPlace(localization, models[i]); });
  }
  LookalikeScores scores(map->models.size());
  for (std::size_t i = 0; i < models.size(); ++i)
    if (wrong[i]) scores[models[i]] = wrong[i]->score;
  if (const auto ambiguity = ambiguityOf(scores)) MapDatabase::open(path).setAmbiguity(*ambiguity, scores);
}

}  // namespace facetloc
