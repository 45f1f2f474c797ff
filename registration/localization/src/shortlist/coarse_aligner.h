// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/lanes.h"
#include "shortlist/place_descriptor.h"

#include <limits>
#include <vector>

namespace facetloc::internal {

// How far one place is laid from another at most: about three standard deviations of the usual prior, which
// is 20 deg and 1 m.
constexpr float kReachTurnDeg = 60;  // between their headings [deg]
constexpr float kReachMove = 2.8f;   // along each axis [m]

/** \brief Which of several walls overlap with another one in height, or nearly: parts of one wall may. */
FACETLOC_ALWAYS_INLINE void overlapInHeight(const Floats& bottom, const Floats& top, const Wall& wall,
                                            Ints& overlaps) {
  constexpr float kGap = 0.05f;  // [m]
  overlaps = (bottom - wall.top <= kGap) & (wall.bottom - top <= kGap);
}

/** \brief How many edges two walls have in common: float, or Floats for several pairs of walls.
 * \param lower, upper differences in height of these edges, NaN where one of the two is not seen [m] */
template <typename Number>
FACETLOC_ALWAYS_INLINE void countEdges(const Number& lower, const Number& upper, Number& edges) {
  constexpr float kError = 0.06f;  // [m]
  const Number none{}, one = none + 1;
  const auto same_lower = (lower < kError) & (lower > -kError),
             same_upper = (upper < kError) & (upper > -kError);
  edges = (same_lower ? one : none) + (same_upper ? one : none);
}

/** \brief How one place may be laid over another: a turn about the vertical, then a move on the floor. */
struct PlaceAlignment {
  float score = std::numeric_limits<float>::lowest();  ///< lowest if nothing can be laid over anything
  float heading = 0;   ///< heading of the scene's upright frame in the model's [rad]
  float x = 0, y = 0;  ///< position of its origin [m]
};

/** \brief A quick look whether two views may show the same place: about a hundredth of the work of a
 * registration, and not as good.
 *
 * Pairs of walls vote for a heading, then for a position: a pair leaves a line of positions, as long as both
 * walls overlap there, and ends of walls that fit leave a point. The best positions are made exact by least
 * squares and compared in depth, each view's coarse picture in the other's. Keeps its buffers; one per
 * thread. The same descriptors give the same answer. */
class CoarseAligner {
public:
  /** \param scene must outlive the aligner */
  explicit CoarseAligner(const PlaceDescriptor& scene);
  /** \param least score that is of use: a model that scores less is known to do so, and nothing else of it */
  PlaceAlignment align(const PlaceDescriptor& model, float least = std::numeric_limits<float>::lowest());

private:
  /** Two walls that may be one. */
  struct Pair {
    float turn;            ///< heading of the model's wall less the heading of the scene's [rad]
    float move;            ///< offset of the model's wall less the offset of the scene's [m]
    float slide0, slide1;  ///< moves along the model's wall with which the two overlap [m]
    float weight;
    const Wall* scene;
    const Wall* model;
  };
  /** A pair that agrees with a heading, and its further contributions there. */
  struct ParallelPair : Pair {
    float cosine, sine;  ///< direction of the heading of the model's wall
    float walls;         ///< worth of the walls and their edges, in walls
    float right, left;   ///< moves along the wall that lay ends over ends, or NaN [m]
  };
  struct Pose {
    float turn, x, y, support;
  };

  static int findMatching(const WallColumns& walls, const Wall& wall, int* matching);
  void findPairs(const PlaceDescriptor& model);
  void findTurns();
  void findPositions(float turn);
  void refine(Pose& pose) const;

  const PlaceDescriptor& scene_;
  const WallColumns scene_walls_;
  PointColumns scene_points_, model_points_;
  std::vector<int> matching_;
  std::vector<Pair> pairs_;
  std::vector<ParallelPair> parallel_;
  std::vector<float> turns_, grid_;
  std::vector<Pose> poses_;
};

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
