// SPDX-License-Identifier: BSD-3-Clause
#include "trajectory/piece_bonds.h"

#include <algorithm>
#include <deque>
#include <vector>

namespace facetloc::internal {
namespace {

// Share of the overlaps of two pieces that contradict their pose, beyond noise and things that moved: within
// a piece it is up to 0.025, of a right bond 0, of a wrong one 0.07 to 0.8.
constexpr double kContradicted = 0.05;

bool isContradicted(const OverlapVerdicts& v) { return v.contradictedShare() > kContradicted; }

// Bonds of a shortest path between two pieces; empty if no path joins them.
std::vector<PiecePair> pathBetween(const PiecePair& ends, const PieceBonds& bonds) {
  std::map<int, int> before{{ends.first, ends.first}};
  std::deque<int> open{ends.first};
  while (!open.empty() && before.count(ends.second) == 0) {
    const int piece = open.front();
    open.pop_front();
    for (const auto& [pair, ignored] : bonds)
      for (const auto& [from, to] : {pair, PiecePair(pair.second, pair.first)})
        if (from == piece && before.emplace(to, piece).second) open.push_back(to);
  }
  std::vector<PiecePair> path;
  if (before.count(ends.second) == 0) return path;
  for (int piece = ends.second; piece != ends.first; piece = before.at(piece))
    path.emplace_back(std::minmax(piece, before.at(piece)));
  return path;
}

}  // namespace

std::optional<PiecePair> weakestBond(const PieceVerdicts& verdicts, const PieceBonds& bonds, int least_ties) {
  for (const auto& [pair, ties] : bonds)
    if (ties < least_ties) return pair;
  const auto share = [&](const PiecePair& pair) {
    const auto found = verdicts.find(pair);
    return found == verdicts.end() ? 0 : found->second.contradictedShare();
  };
  std::optional<PiecePair> worst;
  for (const auto& [pair, v] : verdicts)
    if (pair.first != pair.second && isContradicted(v) && (!worst || share(pair) > share(*worst)))
      worst = pair;
  if (!worst) return {};
  const std::vector<PiecePair> path = pathBetween(*worst, bonds);
  const auto weakest =
      std::max_element(path.begin(), path.end(), [&](const PiecePair& a, const PiecePair& b) {
        return share(a) != share(b) ? share(a) < share(b) : bonds.at(a) > bonds.at(b);
      });
  return weakest == path.end() ? std::nullopt : std::optional(*weakest);
}

}  // namespace facetloc::internal
