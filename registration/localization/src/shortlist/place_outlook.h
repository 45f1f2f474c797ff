// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "shortlist/place_signature.h"

namespace facetloc::internal {

/** \brief How much can be hoped for from laying one place over another (PlaceAligner::align), for a
 * twentieth of its work.
 *
 * Places that are built along two directions at right angles differ by few turns, and once turned by a move
 * along each direction. Every pair of walls that face the same way votes for one move, every pair of ends
 * for one across it: with the weight of the smaller wall, more if upper or lower edges are at one height.
 * What the best moves get, each direction on its own, less what the prior takes for them and for the turn,
 * and level surfaces at one height are the outlook, in proportion to how much the model has. */
class PlaceOutlook {
public:
  /** \param scene must outlive the outlook */
  explicit PlaceOutlook(const PlaceSignature& scene);
  /** \brief Not negative; tells models of one scene apart. Thread-safe. */
  float of(const PlaceSignature& model) const;

private:
  const PlaceSignature& scene_;
  const WallColumns walls_;
};

}  // namespace facetloc::internal
