// SPDX-License-Identifier: BSD-3-Clause
#include "trajectory/overlap_verdict.h"

#include "depth/depth_consistency.h"
#include "poses/pose_fusion.h"

#include <facetloc/registration/pose_prior.h>

#include <algorithm>
#include <deque>
#include <vector>

namespace facetloc::internal {
namespace {

constexpr double kUnknown = 100;  // standard deviation of motions that two views leave free [m, rad]
constexpr PoseRadius kSameTrajectory{0.1, 1};

DepthAgreement agreementAt(const Eigen::Isometry3d& T_a_b, const View& a, const View& b) {
  return DepthComparison(DepthCalibration{}).compareBoth(b.depth, a.depth, T_a_b, kFineColumns);
}

double overlapOf(const DepthAgreement& seen, const DepthPicture& picture) {
  const int step = gridStep(picture, kFineColumns);
  const int pixels = gridPoints(picture.camera.width, step) * gridPoints(picture.camera.height, step);
  return (seen.agree + seen.contradict) / (2.0 * std::max(1, pixels));
}

bool agrees(const DepthAgreement& seen) {
  return seen.agree >= kLeastAgreement * (seen.agree + seen.contradict);
}

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

PoseWithCovariance measured(const PlacedView& placed) {
  Matrix6d information = placed.information;
  information.diagonal().array() += 1 / (kUnknown * kUnknown);
  return {placed.T_a_b, withSharedErrors(symmetricInverse(information))};
}

std::optional<PlacedView> registered(const ViewPlacing& placing, const View& view, const View& other,
                                     const PoseWithCovariance& prior, bool search) {
  auto placed = placing.place(view, other, prior, search);
  if (placed && (placed->agreement < kLeastAgreement || placed->overlap < kLeastOverlap)) placed.reset();
  return placed;
}

bool isClear(const PlacedView& placed) {
  return placed.agreement >= kClearAgreement && placed.overlap >= kLoopOverlap;
}

bool depthAgrees(const Eigen::Isometry3d& T_a_b, const View& a, const View& b) {
  return agrees(agreementAt(T_a_b, a, b));
}

double overlapOf(const Eigen::Isometry3d& T_a_b, const View& a, const View& b) {
  return overlapOf(agreementAt(T_a_b, a, b), b.depth);
}

OverlapVerdict verdictOn(const Eigen::Isometry3d& T_a_b, const View& a, const View& b,
                         const Comparison& compared) {
  const DepthAgreement seen = agreementAt(T_a_b, a, b);
  if (overlapOf(seen, b.depth) < kLeastOverlap) return OverlapVerdict::says_nothing;
  const bool is_elsewhere = compared.placed && !compared.anywhere &&
                            !kSameTrajectory.joins(compared.placed->T_a_b, T_a_b) &&
                            squaredMahalanobis(measured(*compared.placed), T_a_b) > kFarEllipsoid;
  return agrees(seen) && !is_elsewhere ? OverlapVerdict::confirms : OverlapVerdict::contradicts;
}

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
