// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "tools/ranks.h"

#include <facetloc/registration/global_localization.h>

#include <memory>
#include <vector>

namespace facetloc {

/** \brief GlobalLocalization whose local models are shared out over ranks: each registers a view with its own
 * ones, the first ranks the hypotheses of all.
 *
 * The shares are runs of models in the order of the map, so that the answer is that of a single process to
 * the last bit. The first rank keeps the whole map, since any model can be evidence for any place; the others
 * keep their share. */
class ShardedLocalization {
public:
  /** \param threads of each rank over its share; 0 = all cores */
  ShardedLocalization(Map map, const GlobalLocalizationParams& params, const SensorNoise& noise,
                      const Ranks& ranks, int threads);
  /** \brief All local models, on ranks other than the first perhaps without their views. */
  const Map& map() const { return localization_.map(); }

  /** \brief On the first rank. With several, by one thread at a time. */
  Localization localize(const View& scene) const;
  /** \brief On the first rank: lets the others go. */
  void finish() const;
  /** \brief On each other rank: takes part in localize() of the first until that one finishes. */
  void serve() const;

  /** \brief What a rank has found in its share of the local models, or why it could not look there. */
  struct Share {
    std::vector<Hypothesis> hypotheses;
    std::string failure;  // empty if there was none
  };

private:
  Share registerOwn(const View& scene, const std::vector<Candidate>& candidates) const;

  Ranks ranks_;
  int own_begin_, own_end_;  // models
  GlobalLocalization localization_;
};

}  // namespace facetloc
