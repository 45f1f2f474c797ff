// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "graph/pose_graph.h"
#include "trajectory/camera_speed.h"
#include "trajectory/chunked_work.h"
#include "trajectory/trajectory_graph.h"

#include <facetloc/mapping/trajectory_estimation.h>

namespace facetloc::internal {

/** \brief Compares keyframes with earlier ones, and finds the motions between them that can be relied on. */
class LoopSearch {
public:
  explicit LoopSearch(const MappingParams& params) : params_(params) {}

  /** \brief Compares keyframes of one part. A pair known to the trajectory is an overlap; any other a loop
   * that others must confirm. \param first number of the first keyframe that is compared */
  std::vector<KeyframeMotion> withinParts(const TrajectoryGraph& graph, const GraphCovariance& known,
                                          int first, const ChunkedWork& work);
  /** \brief Ties parts where a chain has broken, by keyframes that show the same on both sides. */
  std::vector<KeyframeMotion> betweenParts(const TrajectoryGraph& graph, const GraphCovariance& known,
                                           int first, const CameraSpeed& speed, const ChunkedWork& work);

  /** \brief Verdicts on pieces that are tied into one part, and on each with itself, by all keyframes
   * compared. */
  PieceVerdicts verdicts(const TrajectoryGraph& graph, int threads) const;
  /** \brief Takes out the weakest bond between pieces that contradict each other, again and again.
   * \return true if there was one */
  bool cutContradicted(TrajectoryGraph& graph, int threads);
  int cutBonds() const { return cut_bonds_; }

  void adopt(const LoopSearch& improved) { compared_ = improved.compared_; }

private:
  struct Pair;
  using Comparisons = std::map<std::pair<int, int>, Comparison>;

  std::vector<Pair> pairsOf(int b, const GraphCovariance& known) const;
  void compare(int b, const Comparisons& compared, const TrajectoryGraph& graph, Pair& pair) const;
  void compareTies(const std::vector<std::pair<int, int>>& pairs, const TrajectoryGraph& graph,
                   const ChunkedWork& work);

  MappingParams params_;
  ViewPlacing placing_;
  std::shared_ptr<const Comparisons> compared_ = std::make_shared<Comparisons>();
  /// comparisons of keyframes of different pieces, searched anywhere; empty if refused
  std::map<std::pair<int, int>, std::optional<PlacedView>> ties_;
  int cut_bonds_ = 0;
};

}  // namespace facetloc::internal
