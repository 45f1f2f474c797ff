// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "graph/graph_covariance.h"
#include "graph/independent_ties.h"

#include <vector>

namespace facetloc::internal {

/** \brief Which of some uncertain loops confirm each other: going there by one and back by another must lead
 * to where one was, along the paths of the graph between their ends (pairwise consistency after Mangelson et
 * al., ICRA 2018). Loops whose ends are not apart at either side count as one.
 *
 * The largest sets in which all agree and that have at least `least` loops are taken, unless a contradicting
 * set is more than half as large: repeated corridors confirm several answers. \param loops between different
 * nodes \return for each loop whether it is confirmed. Same input, same answer. */
std::vector<bool> consistentLoops(const std::vector<PoseEdge>& loops, const GraphCovariance& graph, int least,
                                  const NodesApart& apart);

}  // namespace facetloc::internal
