// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sharded_localization.h"

#include <algorithm>
#include <exception>
#include <iterator>
#include <optional>
#include <stdexcept>

namespace facetloc {
namespace {

/** The models of a rank are a run, as long as that of any other rank, or one longer. */
int beginOf(std::size_t rank, std::size_t models, const Ranks& ranks) {
  return static_cast<int>(models * rank / ranks.size());
}

/** A map with a store has none in memory anyway. */
std::shared_ptr<const Map> withViewsOf(int own_begin, int own_end, Map map) {
  for (int i = 0; i < static_cast<int>(map.models.size()) && !map.store; ++i)
    if (i < own_begin || i >= own_end) map.models[i].view = {};
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
      own_begin_(beginOf(ranks.rank(), map.models.size(), ranks)),
      own_end_(beginOf(ranks.rank() + 1, map.models.size(), ranks)),
      localization_(ranks.isFirst() ? std::make_shared<const Map>(std::move(map))
                                    : withViewsOf(own_begin_, own_end_, std::move(map)),
                    ranks.isFirst() ? params : withoutShortlist(params), noise) {
  localization_.setNumberOfThreads(threads);
}

/** What fails is told with what the others send, or they would be heard in the next image. */
ShardedLocalization::Share ShardedLocalization::registerOwn(const View& scene,
                                                            const std::vector<Candidate>& candidates) const
    try {
  std::vector<Candidate> own;
  std::copy_if(candidates.begin(), candidates.end(), std::back_inserter(own),
               [this](const Candidate& c) { return own_begin_ <= c.model && c.model < own_end_; });
  return {localization_.registerWith(own, scene, localization_.prior()), ""};
} catch (const std::exception& e) {
  return {{}, e.what()};
}

Localization ShardedLocalization::localize(const View& scene) const {
  const auto registerAll = [&](const std::vector<Candidate>& candidates) {
    if (ranks_.size() > 1) {
      ranks_.broadcast(std::optional<View>(scene));
      ranks_.broadcast(candidates);
    }
    std::vector<Hypothesis> hypotheses;
    for (Share& share : ranks_.gather(registerOwn(scene, candidates))) {
      if (!share.failure.empty()) throw std::runtime_error(share.failure);
      std::move(share.hypotheses.begin(), share.hypotheses.end(), std::back_inserter(hypotheses));
    }
    return hypotheses;
  };
  return localization_.localizeBy(registerAll, scene);
}

void ShardedLocalization::finish() const { ranks_.broadcast(std::optional<View>()); }

void ShardedLocalization::serve() const {
  while (const auto scene = ranks_.broadcast(std::optional<View>())) {
    const std::vector<Candidate> candidates = ranks_.broadcast(std::vector<Candidate>());
    ranks_.gather(registerOwn(*scene, candidates));
  }
}

}  // namespace facetloc
