// SPDX-License-Identifier: BSD-3-Clause
#include "graph/independent_ties.h"

#include <algorithm>

namespace facetloc::internal {

int independentTies(const std::vector<std::pair<int, int>>& ties, const NodesApart& apart) {
  std::vector<std::pair<int, int>> kept;
  for (const auto& tie : ties)
    if (std::all_of(kept.begin(), kept.end(), [&](const std::pair<int, int>& other) {
          return apart(tie.first, other.first) && apart(tie.second, other.second);
        }))
      kept.push_back(tie);
  return static_cast<int>(kept.size());
}

}  // namespace facetloc::internal
