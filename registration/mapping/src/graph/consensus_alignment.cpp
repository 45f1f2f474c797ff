// SPDX-License-Identifier: BSD-3-Clause
#include "graph/consensus_alignment.h"

#include "graph/consistency_graph.h"

#include <algorithm>

namespace facetloc::internal {
namespace {

constexpr double kSigmas = 3;  // tolerated errors of the session, in standard deviations
constexpr double kTellingStd =
    2;  // largest standard deviation of the session between two keyframes that is informative [m]
constexpr double kTellingRotation = 20 * kDegree;

Agreement compare(const FoundKeyframe& a, const FoundKeyframe& b, const RelativePose& relative,
                  const PlaceTolerance& tolerance) {
  const auto in_session = relative(a.keyframe, b.keyframe);
  if (!in_session) return Agreement::says_nothing;
  const double std = largestTranslationStd(in_session->P), turn_std = largestRotationStd(in_session->P);
  if (std > kTellingStd || turn_std > kTellingRotation) return Agreement::says_nothing;
  const Vector6d off = boxminus(a.T_w_c.T.inverse() * b.T_w_c.T, in_session->T);
  const bool agree = off.tail<3>().norm() <= tolerance.distance + kSigmas * std &&
                     off.head<3>().norm() <= tolerance.rotation + kSigmas * turn_std;
  return agree ? Agreement::agree : Agreement::contradict;
}

}  // namespace

std::vector<FoundKeyframe> consensusAlignment(const std::vector<FoundKeyframe>& found,
                                              const RelativePose& relative, const PlaceTolerance& tolerance,
                                              std::size_t least) {
  const int n = static_cast<int>(found.size());
  const ConsistencyGraph agreement(
      n, [&](int i, int j) { return compare(found[i], found[j], relative, tolerance); });
  ConsistencyGraph::Largest largest = agreement.largest(
      allOf(n), [](const ConsistencyGraph::Set& set) { return static_cast<int>(set.size()); });
  if (largest.members.empty() || largest.members.size() < least || !largest.is_clear) return {};
  std::sort(largest.members.begin(), largest.members.end());
  std::vector<FoundKeyframe> out;
  for (const int i : largest.members) out.push_back(found[i]);
  return out;
}

}  // namespace facetloc::internal
