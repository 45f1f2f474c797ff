// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "graph/graph_covariance.h"
#include "shortlist/plane_triplet_matcher.h"
#include "trajectory/camera_speed.h"
#include "trajectory/chunked_work.h"
#include "trajectory/trajectory_graph.h"

#include <optional>
#include <utility>
#include <vector>

namespace facetloc::internal {

/** \brief How pairs of keyframes are searched for. */
struct TieSearch {
  PoseWithCovariance prior;                ///< relative pose of a pair, about the identity
  std::optional<CameraMounting> mounting;  ///< with it, a PlaceIndex bounds the search
  ChunkedWork work{};
  /// pairs up to which all are compared: an index costs as much as 6000 comparisons for each keyframe
  long long exhaustive_up_to = 20'000'000;
};

/** \brief Finds keyframes that may show the same place by how well their planes overlay each other
 * (localization/METHOD 2.7). Never changes; thread-safe. */
class SimilarViews {
public:
  /** \param prior relative pose of two views, about the identity */
  SimilarViews(const std::vector<TrajectoryNode>& keyframes, const PoseWithCovariance& prior);
  /** \brief True if the planes of a keyframe fix a pose. */
  bool spansSpace(int keyframe) const { return matchers_[keyframe].spansSpace(); }
  /** \brief The 15 keyframes that overlay a keyframe best, the best first. */
  std::vector<int> mostSimilar(int keyframe, const std::vector<int>& among) const;

private:
  std::vector<PlaneTripletMatcher> matchers_;
  std::vector<PlaneColumns> planes_;
};

/** \brief Pairs of keyframes of different parts that may show the same place: those close in order, and for
 * each keyframe the earlier ones that SimilarViews finds. Of many keyframes with
 * a known mounting, only the most similar ones by a PlaceIndex are overlaid.
 *
 * \param first number of the first keyframe that pairs are formed with */
std::vector<std::pair<int, int>> tieCandidates(const std::vector<TrajectoryNode>& keyframes, int first,
                                               const TieSearch& search);

/** \brief Bound on ties by the distance that the camera may have covered between two parts. */
class TravelBound {
public:
  TravelBound(const std::vector<TrajectoryNode>& keyframes, const CameraSpeed& speed,
              const GraphCovariance& graph);

  /** \brief False if the camera would have had to move much faster than it does. Anything is possible across
   * an interruption. */
  bool allows(const PoseEdge& tie) const;

private:
  std::pair<int, int> nearestInTime(int part_a, int part_b) const;
  double farthest(int first, int last) const;

  const std::vector<TrajectoryNode>& keyframes_;
  const CameraSpeed& speed_;
  const GraphCovariance& graph_;
};

}  // namespace facetloc::internal
