// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "shortlist/place_descriptor.h"

namespace facetloc::internal {

/** \brief A quick estimate of the score of laying one place over another (CoarseAligner::align), for a
 * twentieth of its work.
 *
 * Places that are built along two directions at right angles differ by few turns, and once turned by a move
 * along each direction. Every pair of walls that face the same way votes for one move, every pair of ends
 * for one across it: with the weight of the smaller wall, more if upper or lower edges are at one height.
 * The score is the number of votes of the best moves, each direction on its own, less the cost of them and of
 * the turn by the prior, plus level surfaces at one height, relative to the size of the model. */
class Prescore {
public:
  /** \param scene must outlive the object */
  explicit Prescore(const PlaceDescriptor& scene);
  /** \brief Not negative; tells models of one scene apart. Thread-safe. */
  float of(const PlaceDescriptor& model) const;

private:
  const PlaceDescriptor& scene_;
  const WallColumns walls_;
};

}  // namespace facetloc::internal
