// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "graph/pose_graph.h"
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

/** \brief Pairs of keyframes of different parts that may show the same place: those close in order, and for
 * each keyframe the earlier ones whose planes overlay best (localization/METHOD 2.7). Of many keyframes with
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
