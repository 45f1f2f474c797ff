// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "ranking/global_localization.h"

#include <facetloc/features/map_metadata.h>

#include <functional>
#include <optional>
#include <vector>

/** \file
 * A map is asked about itself. How much do wrong places score in it? Nothing else tells a place that
 * looks like many from one that looks like no other where the map does not hold the right one
 * (localization/METHOD 1.5). How far are its views from where those around them have them (METHOD 2.3)?
 */

namespace facetloc::internal {

/** \brief The local models whose views are asked for: all that were images and have a pose, or some of a
 * large map. */
std::vector<int> viewsToAsk(const Map& map);

/** \brief How far the surroundings of a place reach, by whose local models it is found and not mistaken: 3 m,
 * and in a small part of a map a third of its extent. */
double reachOfSurroundings(const Map& map, int part);

/** \brief The best wrong place for the view of a local model, in its map without the models that satisfy
 * excluded or are in its surroundings, which those of other parts of the map may be; nothing if no other
 * place is like it. */
std::optional<Hypothesis> wrongPlace(const GlobalLocalization& localization, int model,
                                     const std::function<bool(int model)>& excluded = {});

/** \brief Score of the best wrong place of each local model; nothing where none was asked for or found.
 */
using AliasScores = std::vector<std::optional<double>>;

/** \brief The mean of the highest tenth; nothing of no scores. */
std::optional<MapAmbiguity> ambiguityOf(const AliasScores& scores);

/** \brief Puts them, and the ambiguity, into a map. */
void setAmbiguity(const AliasScores& scores, Map& map);

/** \brief A view of a map, aligned anew with those around it. */
struct RealignedView {
  Vector6d error;        ///< perturbation from the pose found to the one in the map
  Matrix6d information;  ///< all compared pixels as independent measurements, without the prior
};

/** \brief Aligns views of a map with their surroundings by all pixels, from where they are. */
std::vector<RealignedView> realignedViews(const std::shared_ptr<const Map>& map, int threads);

/** \brief The likeliest errors of such views; of few, drawn towards the usual. */
ConsideredErrors consideredErrors(const std::vector<RealignedView>& views);

}  // namespace facetloc::internal
