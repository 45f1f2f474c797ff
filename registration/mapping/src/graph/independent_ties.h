// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <utility>
#include <vector>

namespace facetloc::internal {

/** \brief True for two nodes that see different things. */
using NodesApart = std::function<bool(int, int)>;

/** \brief Size of the set of ties that a greedy search finds in which each two are apart at both ends: ties
 * that share a view, or were seen from next to the same place, are one witness. \param ties numbers of the
 * nodes at their ends */
int independentTies(const std::vector<std::pair<int, int>>& ties, const NodesApart& apart);

}  // namespace facetloc::internal
