// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "threads/in_parallel.h"
#include "trajectory/keyframe_selection.h"

#include <algorithm>

namespace facetloc::internal {

/** \brief Threads of a computation, and the function that receives its progress. */
struct ChunkedWork {
  int threads = 1;                         ///< 0 = all cores
  std::function<void(double)> progress{};  ///< receives the share of the work that is done; may be empty

  /** \brief A section of this work, between two shares of it. */
  ChunkedWork section(double begin, double end) const {
    if (!progress) return *this;
    return {threads, [report = progress, begin, end](double done) { report(begin + done * (end - begin)); }};
  }

  /** \brief Calls a function with 0 .. n - 1 in parallel, and reports progress in between. */
  void forEach(int n, const std::function<void(int)>& function) const {
    constexpr int kChunk = 64;
    for (int first = 0; first < n; first += kChunk) {
      if (progress) progress(double(first) / n);
      forEachInParallel(std::min(kChunk, n - first), threads, [&](int i) { function(first + i); });
    }
  }
};

/** \brief Pairs of keyframes of different parts that may show the same place: those close in order, and for
 * each keyframe the earlier ones whose planes overlay best (localization/METHOD 2.7). Of many keyframes with
 * a known mounting, only the most similar ones by a PlaceIndex are overlaid.
 *
 * \param first number of the first keyframe that pairs are formed with \param exhaustive_up_to pairs up to
 * which all are compared: an index costs as much as 6000 comparisons for each keyframe */
std::vector<std::pair<int, int>> tieCandidates(const std::vector<TrajectoryNode>& keyframes, int first,
                                               const std::optional<CameraMounting>& mounting,
                                               const ChunkedWork& work,
                                               long long exhaustive_up_to = 20'000'000);

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
