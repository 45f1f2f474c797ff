// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/apps/sharded_localization.h>

#include <algorithm>
#include <iterator>
#include <numeric>
#include <optional>

namespace facetloc {
namespace {

/** A run of the models, as long as that of any other rank, or one longer. */
std::vector<int> shareOf(std::size_t models, const Ranks& ranks) {
  const auto begin = [&](std::size_t rank) { return static_cast<int>(models * rank / ranks.size()); };
  std::vector<int> own(begin(ranks.rank() + 1) - begin(ranks.rank()));
  std::iota(own.begin(), own.end(), begin(ranks.rank()));
  return own;
}

/** A map with a store has none in memory anyway. */
std::shared_ptr<const Map> withViewsOf(const std::vector<int>& own, Map map) {
  if (map.store) return std::make_shared<const Map>(std::move(map));
  std::vector<View> views;
  for (const int i : own) views.push_back(std::move(map.models[i].view));
  for (LocalModel& model : map.models) model.view = {};
  for (std::size_t i = 0; i < own.size(); ++i) map.models[own[i]].view = std::move(views[i]);
  return std::make_shared<const Map>(std::move(map));
}

/** The first rank, which has all views, makes the shortlist. */
GlobalLocalizationParams withoutShortlist(GlobalLocalizationParams params) {
  params.index.shortlist = 0;
  return params;
}

}  // namespace

ShardedLocalization::ShardedLocalization(Map map, const GlobalLocalizationParams& params,
                                         const SensorNoise& noise, const Ranks& ranks, int threads)
    : ranks_(ranks),
      own_(shareOf(map.models.size(), ranks)),
      localization_(ranks.isFirst() ? std::make_shared<const Map>(std::move(map))
                                    : withViewsOf(own_, std::move(map)),
                    ranks.isFirst() ? params : withoutShortlist(params), noise) {
  localization_.setNumberOfThreads(threads);
}

std::vector<Hypothesis> ShardedLocalization::registerOwn(const View& scene,
                                                         const std::vector<int>& candidates) const {
  std::vector<int> models;
  std::set_intersection(own_.begin(), own_.end(), candidates.begin(), candidates.end(),
                        std::back_inserter(models));
  return localization_.registerWith(models, scene, localization_.prior());
}

Localization ShardedLocalization::localize(const View& scene) const {
  const std::vector<int> candidates = localization_.candidates(scene);
  if (ranks_.size() > 1) {
    ranks_.broadcast(std::optional<View>(scene));
    ranks_.broadcast(candidates);
  }
  std::vector<Hypothesis> hypotheses;
  for (std::vector<Hypothesis>& of_rank : ranks_.gather(registerOwn(scene, candidates)))
    std::move(of_rank.begin(), of_rank.end(), std::back_inserter(hypotheses));
  return localization_.rank(scene, std::move(hypotheses));
}

void ShardedLocalization::finish() const { ranks_.broadcast(std::optional<View>()); }

void ShardedLocalization::serve() const {
  while (const auto scene = ranks_.broadcast(std::optional<View>())) {
    const std::vector<int> candidates = ranks_.broadcast(std::vector<int>());
    ranks_.gather(registerOwn(*scene, candidates));
  }
}

}  // namespace facetloc
