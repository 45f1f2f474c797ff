// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

namespace facetloc::internal {

/** \brief The relation of two findings. */
enum class Agreement : char { says_nothing, agree, contradict };

/** \brief Findings of which some may be wrong, each compared with each other: right ones agree, and wrong
 * ones seldom do (pairwise consistency after Mangelson et al., ICRA 2018). */
class ConsistencyGraph {
public:
  using Set = std::vector<int>;  ///< numbers of findings
  using Size = std::function<int(const Set&)>;

  ConsistencyGraph(int n, const std::function<Agreement(int i, int j)>& compare);

  /** \brief Findings that all agree with each other, and those that contradict one of them. */
  struct Largest {
    Set members, against;
    bool is_clear = false;  ///< a contradicting set is less than half as large
  };
  /** \brief The largest set among some findings that a greedy search from each of them finds. \param size by
   * which sets are compared Same input, same answer. */
  Largest largest(const Set& among, const Size& size) const;

private:
  Set largestSet(const Set& among, const Size& size) const;

  std::vector<std::vector<Agreement>> verdicts_;
};

/** \brief 0, 1, ..., n - 1 */
ConsistencyGraph::Set allOf(int n);

}  // namespace facetloc::internal
