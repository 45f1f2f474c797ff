// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/map_ambiguity.h"

#include "poses/pose_fusion.h"

#include <facetloc/features/map_metadata.h>
#include <facetloc/features/pose.h>

#include <algorithm>
#include <numeric>

namespace facetloc::internal {
namespace {

constexpr std::size_t kMostViews = 200;
constexpr std::size_t kMostRegistrations = 400000;  // where every model is registered with every view

}  // namespace

std::vector<int> viewsToAsk(const Map& map) {
  const std::vector<char> rendered = renderedViews(map);
  std::vector<int> models;
  for (std::size_t i = 0; i < map.models.size(); ++i)
    if (map.models[i].T_w_m && map.models[i].hasPicture() && !rendered[i])
      models.push_back(static_cast<int>(i));
  const std::size_t most =
      map.camera.mounting ? kMostViews : std::min(kMostViews, kMostRegistrations / (1 + models.size()));
  if (models.size() <= most) return models;
  std::vector<int> some;
  for (std::size_t i = 0; i < most; ++i) some.push_back(models[i * models.size() / most]);
  return some;
}

double reachOfSurroundings(const Map& map, int part) {
  constexpr double kFarthest = 3;  // [m]
  Eigen::AlignedBox3d extent;
  for (const LocalModel& model : map.models)
    if (model.T_w_m && model.part == part) extent.extend(model.T_w_m->translation());
  return extent.isEmpty() ? kFarthest : std::min(kFarthest, extent.diagonal().norm() / 3);
}

std::optional<Hypothesis> wrongPlace(const GlobalLocalization& localization, int model,
                                     const std::function<bool(int)>& excluded) {
  const Map& map = localization.map();
  const Eigen::Isometry3d& T_w_m = *map.models[model].T_w_m;
  const int part = map.models[model].part;
  const double reach = reachOfSurroundings(map, part);
  const auto isNearOrExcluded = [&](int i) {  // or may be, for all that is known
    const auto& T = map.models[i].T_w_m;
    return !T || map.models[i].part != part || (T->translation() - T_w_m.translation()).norm() <= reach ||
           (excluded && excluded(i));
  };
  View view = *map.view(model);
  if (!view.camera) view.camera = std::make_shared<const Camera>(map.camera);
  Localization answer = localization.localize(view, isNearOrExcluded);
  for (Hypothesis& h : answer.hypotheses)
    if (h.T_w_c && !internal::kSameSurroundings.joins(*h.T_w_c, T_w_m)) return std::move(h);
  return {};
}

std::optional<MapAmbiguity> ambiguityOf(const AliasScores& scores) {
  std::vector<double> found;
  for (const std::optional<double>& score : scores)
    if (score) found.push_back(*score);
  if (found.empty()) return {};
  const std::size_t tenth = (found.size() + 9) / 10;
  const auto end = found.begin() + static_cast<std::ptrdiff_t>(tenth);
  std::partial_sort(found.begin(), end, found.end(), std::greater<>());
  return MapAmbiguity{std::accumulate(found.begin(), end, 0.0) / static_cast<double>(tenth),
                      static_cast<int>(found.size())};
}

void setAmbiguity(const AliasScores& scores, Map& map) {
  map.ambiguity = ambiguityOf(scores);
  for (std::size_t i = 0; i < map.models.size(); ++i) map.models[i].alias_score = scores[i];
}

}  // namespace facetloc::internal
