// SPDX-License-Identifier: BSD-3-Clause
#include "graph/consistency_graph.h"

#include "poses/pose_fusion.h"

#include <algorithm>
#include <map>
#include <numeric>

namespace facetloc::internal {
namespace {

constexpr double kEllipsoid = chiSquareQuantile(6, 0.95);
constexpr double kTellingRound = 0.5;  // largest standard deviation of an informative round trip [m]
constexpr double kTellingRoundRotation = 10 * kDegree;

using RelativePoses = std::map<int, std::vector<std::optional<PoseWithCovariance>>>;  // keyed by node

/** Findings of which some may be wrong, each compared with each other: right ones agree, and wrong ones
 * seldom do. Same input, same answer. */
class ConsistencyGraph {
public:
  using Set = std::vector<int>;  // numbers of findings
  using Size = std::function<int(const Set&)>;

  /** \param agree whether two findings do; nothing where one says nothing about the other */
  ConsistencyGraph(int n, const std::function<std::optional<bool>(int i, int j)>& agree)
      : agree_(n, std::vector<std::optional<bool>>(n)) {
    for (int i = 0; i < n; ++i)
      for (int j = i + 1; j < n; ++j) agree_[i][j] = agree_[j][i] = agree(i, j);
  }

  Set all() const {
    Set all(agree_.size());
    std::iota(all.begin(), all.end(), 0);
    return all;
  }

  /** Findings that all agree with each other, and those that contradict one of them. */
  struct Largest {
    Set members, against;
    bool is_clear = false;  // a contradicting set is less than half as large
  };
  /** The largest set among some findings that a greedy search from each of them finds. \param size by which
   * sets are compared */
  Largest largest(const Set& among, const Size& size) const {
    Largest out;
    out.members = largestSet(among, size);
    for (const int i : among) {
      if (std::find(out.members.begin(), out.members.end(), i) != out.members.end()) continue;
      if (std::any_of(out.members.begin(), out.members.end(), [&](int j) { return agree_[i][j] == false; }))
        out.against.push_back(i);
    }
    out.is_clear = 2 * size(largestSet(out.against, size)) <= size(out.members);
    return out;
  }

private:
  Set largestSet(const Set& among, const Size& size) const {
    Set best;
    for (const int first : among) {
      Set set{first};
      for (const int other : among)
        if (other != first &&
            std::all_of(set.begin(), set.end(), [&](int i) { return agree_[i][other] == true; }))
          set.push_back(other);
      if (size(set) > size(best)) best = std::move(set);
    }
    return best;
  }

  std::vector<std::vector<std::optional<bool>>> agree_;
};

std::optional<bool> agree(const PoseEdge& a, const PoseEdge& b, const RelativePoses& from) {
  const auto &there = from.at(a.to)[b.to], &back = from.at(b.from)[a.from];
  if (!there || !back) return {};
  const PoseWithCovariance round = a.T_from_to * *there * inverse(b.T_from_to) * *back;
  if (largestTranslationStd(round.P) > kTellingRound || largestRotationStd(round.P) > kTellingRoundRotation)
    return {};
  const double off = squaredMahalanobis({Eigen::Isometry3d::Identity(), round.P}, round.T);
  return off < kEllipsoid;
}

constexpr double kSigmas = 3;      // tolerated errors of the session, in standard deviations
constexpr double kTellingStd = 2;  // largest standard deviation in the session that tells something [m]
constexpr double kTellingRotation = 20 * kDegree;

std::optional<bool> agree(const FoundKeyframe& a, const FoundKeyframe& b, const RelativePose& relative) {
  const auto in_session = relative(a.keyframe, b.keyframe);
  if (!in_session) return {};
  const double std = largestTranslationStd(in_session->P), turn_std = largestRotationStd(in_session->P);
  if (std > kTellingStd || turn_std > kTellingRotation) return {};
  const Vector6d off = boxminus(a.T_w_c.T.inverse() * b.T_w_c.T, in_session->T);
  return off.tail<3>().norm() <= kSameAnswer.distance + kSigmas * std &&
         off.head<3>().norm() <= kDegree * kSameAnswer.angle_deg + kSigmas * turn_std;
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
  const ConsistencyGraph agreement(n, [&](int i, int j) { return agree(loops[i], loops[j], from); });
  const auto witnesses = [&](const ConsistencyGraph::Set& set) {
    std::vector<std::pair<int, int>> ties;
    for (const int i : set) ties.emplace_back(loops[i].from, loops[i].to);
    return independentTies(ties, apart);
  };

  std::vector<bool> confirmed(loops.size(), false);
  ConsistencyGraph::Set left = agreement.all();
  for (;;) {
    const ConsistencyGraph::Largest largest = agreement.largest(left, witnesses);
    if (largest.members.empty() || witnesses(largest.members) < least) return confirmed;
    for (const int i : largest.members) confirmed[i] = largest.is_clear;
    for (const ConsistencyGraph::Set* done : {&largest.members, &largest.against})
      for (const int i : *done) left.erase(std::find(left.begin(), left.end(), i));
  }
}

std::vector<FoundKeyframe> consensusAlignment(const std::vector<FoundKeyframe>& found,
                                              const RelativePose& relative, std::size_t least) {
  const int n = static_cast<int>(found.size());
  const ConsistencyGraph agreement(n, [&](int i, int j) { return agree(found[i], found[j], relative); });
  ConsistencyGraph::Largest largest = agreement.largest(
      agreement.all(), [](const ConsistencyGraph::Set& set) { return static_cast<int>(set.size()); });
  if (largest.members.empty() || largest.members.size() < least || !largest.is_clear) return {};
  std::sort(largest.members.begin(), largest.members.end());
  std::vector<FoundKeyframe> out;
  for (const int i : largest.members) out.push_back(found[i]);
  return out;
}

}  // namespace facetloc::internal
