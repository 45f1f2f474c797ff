// SPDX-License-Identifier: BSD-3-Clause
#include "graph/consistency_graph.h"

#include <algorithm>
#include <numeric>

namespace facetloc::internal {

ConsistencyGraph::ConsistencyGraph(int n, const std::function<Agreement(int i, int j)>& compare)
    : verdicts_(n, std::vector<Agreement>(n, Agreement::says_nothing)) {
  for (int i = 0; i < n; ++i)
    for (int j = i + 1; j < n; ++j) verdicts_[i][j] = verdicts_[j][i] = compare(i, j);
}

ConsistencyGraph::Set ConsistencyGraph::largestSet(const Set& among, const Size& size) const {
  Set best;
  for (const int first : among) {
    Set set{first};
    for (const int other : among)
      if (other != first &&
          std::all_of(set.begin(), set.end(), [&](int i) { return verdicts_[i][other] == Agreement::agree; }))
        set.push_back(other);
    if (size(set) > size(best)) best = std::move(set);
  }
  return best;
}

ConsistencyGraph::Largest ConsistencyGraph::largest(const Set& among, const Size& size) const {
  Largest out;
  out.members = largestSet(among, size);
  for (const int i : among) {
    if (std::find(out.members.begin(), out.members.end(), i) != out.members.end()) continue;
    if (std::any_of(out.members.begin(), out.members.end(),
                    [&](int j) { return verdicts_[i][j] == Agreement::contradict; }))
      out.against.push_back(i);
  }
  out.is_clear = 2 * size(largestSet(out.against, size)) <= size(out.members);
  return out;
}

ConsistencyGraph::Set allOf(int n) {
  ConsistencyGraph::Set all(n);
  std::iota(all.begin(), all.end(), 0);
  return all;
}

}  // namespace facetloc::internal
