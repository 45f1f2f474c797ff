// SPDX-License-Identifier: BSD-3-Clause
#include "graph/loop_consistency.h"

#include "graph/consistency_graph.h"

#include <facetloc/features/pose.h>

#include <algorithm>
#include <map>

namespace facetloc::internal {
namespace {

constexpr double kEllipsoid = chiSquareQuantile(6, 0.95);
constexpr double kTellingStd = 0.5;  // largest standard deviation of an informative round trip [m]
constexpr double kTellingRotation = 10 * kDegree;

using RelativePoses = std::map<int, std::vector<std::optional<PoseWithCovariance>>>;  // keyed by node

Agreement compare(const PoseEdge& a, const PoseEdge& b, const RelativePoses& from) {
  const auto &there = from.at(a.to)[b.to], &back = from.at(b.from)[a.from];
  if (!there || !back) return Agreement::says_nothing;
  const PoseWithCovariance round = a.T_from_to * *there * inverse(b.T_from_to) * *back;
  if (largestTranslationStd(round.P) > kTellingStd || largestRotationStd(round.P) > kTellingRotation)
    return Agreement::says_nothing;
  const double off = squaredMahalanobis({Eigen::Isometry3d::Identity(), round.P}, round.T);
  return off < kEllipsoid ? Agreement::agree : Agreement::contradict;
}

}  // namespace

int independentTies(const std::vector<std::pair<int, int>>& ties, const NodesApart& apart) {
  std::vector<std::pair<int, int>> kept;
  for (const auto& tie : ties)
    if (std::all_of(kept.begin(), kept.end(), [&](const std::pair<int, int>& other) {
          return apart(tie.first, other.first) && apart(tie.second, other.second);
        }))
      kept.push_back(tie);
  return static_cast<int>(kept.size());
}

std::vector<bool> consistentLoops(const std::vector<PoseEdge>& loops, const GraphCovariance& graph, int least,
                                  const NodesApart& apart) {
  RelativePoses from;
  for (const PoseEdge& loop : loops)
    for (const int node : {loop.from, loop.to})
      if (!from.count(node)) from.emplace(node, graph.relativeTo(node));
  const int n = static_cast<int>(loops.size());
  const ConsistencyGraph agreement(n, [&](int i, int j) { return compare(loops[i], loops[j], from); });
  const auto witnesses = [&](const ConsistencyGraph::Set& set) {
    std::vector<std::pair<int, int>> ties;
    for (const int i : set) ties.emplace_back(loops[i].from, loops[i].to);
    return independentTies(ties, apart);
  };

  std::vector<bool> confirmed(loops.size(), false);
  ConsistencyGraph::Set left = allOf(n);
  for (;;) {
    const ConsistencyGraph::Largest largest = agreement.largest(left, witnesses);
    if (largest.members.empty() || witnesses(largest.members) < least) return confirmed;
    for (const int i : largest.members) confirmed[i] = largest.is_clear;
    for (const ConsistencyGraph::Set* done : {&largest.members, &largest.against})
      for (const int i : *done) left.erase(std::find(left.begin(), left.end(), i));
  }
}

}  // namespace facetloc::internal
