// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/loop_consistency.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

namespace facetloc::internal {
namespace {

constexpr double kEllipsoid = 12.59;  // of 95 % in 6 degrees of freedom
constexpr double kTellingStd = 0.5;   // of a round trip, beyond which it tells nothing [m]
constexpr double kTellingRotation = 10 * kDegree;

enum class Verdict { says_nothing, agree, contradict };

/** All loops compared with each other. */
class Comparison {
public:
  Comparison(const std::vector<PoseEdge>& loops, const GraphCovariance& graph) : loops_(loops) {
    for (const PoseEdge& loop : loops)
      for (const int node : {loop.from, loop.to})
        if (!from_.count(node)) from_.emplace(node, graph.relativeTo(node));
    const std::size_t n = loops.size();
    verdicts_.assign(n, std::vector<Verdict>(n, Verdict::says_nothing));
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i + 1; j < n; ++j) verdicts_[i][j] = verdicts_[j][i] = compare(loops[i], loops[j]);
  }

  Verdict operator()(int i, int j) const { return verdicts_[i][j]; }

  /** The largest set of those left that a greedy search from each of them finds. */
  std::vector<int> largestSet(const std::vector<int>& left) const {
    std::vector<int> best;
    for (const int first : left) {
      std::vector<int> set{first};
      for (const int other : left)
        if (other != first &&
            std::all_of(set.begin(), set.end(), [&](int i) { return (*this)(i, other) == Verdict::agree; }))
          set.push_back(other);
      if (views(set) > views(best)) best = std::move(set);
    }
    return best;
  }

  /** Number of different keyframes that the loops of a set come from. */
  int views(const std::vector<int>& set) const {
    std::set<int> from, to;
    for (const int i : set) from.insert(loops_[i].from), to.insert(loops_[i].to);
    return static_cast<int>(std::min(from.size(), to.size()));
  }

  bool contradicts(int i, const std::vector<int>& set) const {
    return std::any_of(set.begin(), set.end(), [&](int j) { return (*this)(i, j) == Verdict::contradict; });
  }

private:
  Verdict compare(const PoseEdge& a, const PoseEdge& b) const {
    const auto &there = from_.at(a.to)[b.to], &back = from_.at(b.from)[a.from];
    if (!there || !back) return Verdict::says_nothing;
    const PoseWithCovariance round = a.T_from_to * *there * inverse(b.T_from_to) * *back;
    if (largestTranslationStd(round.P) > kTellingStd || largestRotationStd(round.P) > kTellingRotation)
      return Verdict::says_nothing;
    const Vector6d off = perturbation(Eigen::Isometry3d::Identity(), round.T);
    return off.dot(round.P.ldlt().solve(off)) < kEllipsoid ? Verdict::agree : Verdict::contradict;
  }

  const std::vector<PoseEdge>& loops_;
  std::map<int, std::vector<std::optional<PoseWithCovariance>>> from_;
  std::vector<std::vector<Verdict>> verdicts_;
};

}  // namespace

std::vector<bool> consistentLoops(const std::vector<PoseEdge>& loops, const GraphCovariance& graph,
                                  int least) {
  const Comparison comparison(loops, graph);
  std::vector<bool> confirmed(loops.size(), false);
  std::vector<int> left(loops.size());
  std::iota(left.begin(), left.end(), 0);
  for (;;) {
    const std::vector<int> set = comparison.largestSet(left);
    if (comparison.views(set) < least) break;
    std::vector<int> against, others;
    for (const int i : left) {
      if (std::find(set.begin(), set.end(), i) != set.end()) continue;
      (comparison.contradicts(i, set) ? against : others).push_back(i);
    }
    const bool is_clear = 2 * comparison.views(comparison.largestSet(against)) <= comparison.views(set);
    for (const int i : set) confirmed[i] = is_clear;
    left = std::move(others);
  }
  return confirmed;
}

}  // namespace facetloc::internal
