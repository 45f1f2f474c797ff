// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "graph/pose_graph.h"

#include <utility>

namespace facetloc::internal {

/** \brief True for two nodes that see different things. */
using NodesApart = std::function<bool(int, int)>;

/** \brief Size of the set of ties that a greedy search finds in which each two are apart at both ends: ties
 * that share a view, or were seen from next to the same place, are one witness. \param ties numbers of the
 * nodes at their ends */
int independentTies(const std::vector<std::pair<int, int>>& ties, const NodesApart& apart);

/** \brief Which of some uncertain loops confirm each other: going there by one and back by another must lead
 * to where one was, along the paths of the graph between their ends (pairwise consistency after Mangelson et
 * al., ICRA 2018). Loops whose ends are not apart at either side count as one.
 *
 * The largest sets in which all agree and that have at least `least` loops are taken, unless a contradicting
 * set is more than half as large: repeated corridors confirm several answers. \param loops between different
 * nodes \return for each loop whether it is confirmed. Same input, same answer. */
std::vector<bool> consistentLoops(const std::vector<PoseEdge>& loops, const GraphCovariance& graph, int least,
                                  const NodesApart& apart);

/** \brief A keyframe of a session that was found in a map. */
struct FoundKeyframe {
  int keyframe = 0;
  PoseWithCovariance T_w_c;  ///< pose in the map
};

/** \brief T_a_b of two keyframes by the session alone; nothing if it does not know. */
using RelativePose = std::function<std::optional<PoseWithCovariance>(int a, int b)>;

/** \brief The largest set of found keyframes in which each two are as far from each other as the session
 * says, within kSameAnswer and its errors.
 *
 * Nothing if it is smaller than `least`, or if a set that contradicts it is more than half as large: places
 * that look the same confirm each other. Same input, same answer. */
std::vector<FoundKeyframe> consensusAlignment(const std::vector<FoundKeyframe>& found,
                                              const RelativePose& relative, std::size_t least);

}  // namespace facetloc::internal
