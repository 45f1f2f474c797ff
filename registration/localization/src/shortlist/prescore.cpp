// SPDX-License-Identifier: BSD-3-Clause
#include "base/lanes.h"
#include "shortlist/coarse_aligner.h"

#include <facetloc/features/pose.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace facetloc::internal {
namespace {

constexpr float kQuarter = static_cast<float>(90 * kDegree);
constexpr float kLargestTurn = static_cast<float>(kReachTurnDeg * kDegree);
constexpr float kTurnPrior = 1.5f;  // worth of a turn by a radian, squared
constexpr float kStep = 0.05f;      // spacing of moves [m]
constexpr int kMoves = 112;
constexpr float kReach = 0.5f * kStep * kMoves;      // kReachMove, in whole vectors [m]
constexpr float kMovePrior = 0.4f;                   // worth of a move by a metre, squared
constexpr float kAside = 0.5f;                       // worth of votes for the next moves
constexpr float kEdge = 1.5f, kEnd = 1;              // worth of a common edge, of a common end, in walls
constexpr float kSurface = 2, kHeightError = 0.05f;  // worth of a common surface; [m]
constexpr float kBaseWeight = 2, kPower = 0.6f;

// Votes for moves in one direction; the first and the last are for those that are too large.
using Votes = std::array<float, kMoves + 2>;

FACETLOC_ALWAYS_INLINE void bound(Floats& bin) {
  const Floats first{}, last = first + (kMoves + 1.5f);
  bin = bin > first ? bin : first;  // where a value is NaN, too
  bin = bin < last ? bin : last;
}

FACETLOC_ALWAYS_INLINE void read(const std::vector<float>& column, std::int32_t first, Floats& values) {
  std::memcpy(&values, &column[static_cast<std::size_t>(first)], sizeof values);
}

// Votes of the best move.
FACETLOC_ALWAYS_INLINE float most(Votes& votes) {
  votes.front() = votes.back() = 0;
  Floats best{};
  for (int i = 0; i < kMoves; i += kLanes) {
    Floats before, at, after;
    std::memcpy(&before, &votes[i], sizeof before);
    std::memcpy(&at, &votes[i + 1], sizeof at);
    std::memcpy(&after, &votes[i + 2], sizeof after);
    const Floats move = kStep * (kLaneOffset + static_cast<float>(i)) - kReach,
                 got = at + kAside * (before + after) - kMovePrior * move * move;
    best = got > best ? got : best;
  }
  float of_lanes = 0;
  for (int lane = 0; lane < kLanes; ++lane) of_lanes = best[lane] > of_lanes ? best[lane] : of_lanes;
  return of_lanes;
}

// Votes of the best moves if the model's main heading is the scene's plus quarters of a turn.
FACETLOC_MULTIVERSION float bestMoves(const PlaceDescriptor& scene, const WallColumns& walls,
                                      const PlaceDescriptor& model, int quarters) {
  constexpr float kMiddle = kReach / kStep + 1.5f;
  const Floats none{};
  Votes votes[2] = {};
  for (int k = 0; k < 4; ++k) {
    const std::int32_t begin = scene.facing[(k - quarters) & 3], end = scene.facing[((k - quarters) & 3) + 1];
    // Moves along the first two main headings; walls that face the other way see them reversed.
    const float along = (k & 2 ? -1 : 1) / kStep, across = ((k + 1) & 2 ? -1 : 1) / kStep;
    Votes &by_wall = votes[k & 1], &by_end = votes[~k & 1];
    for (std::int32_t i = model.facing[k]; i < model.facing[k + 1]; ++i) {
      const Wall& m = model.walls[static_cast<std::size_t>(i)];
      const float m_right = m.seenRight(), m_left = m.seenLeft(), m_bottom = m.seenBottom(),
                  m_top = m.seenTop();
      for (std::int32_t j = begin; j < end; j += kLanes) {
        Floats offset, bottom, top, weight, seen_right, seen_left, seen_bottom, seen_top;
        read(walls.offset, j, offset), read(walls.weight, j, weight);
        read(walls.bottom, j, bottom), read(walls.top, j, top);
        read(walls.seen_right, j, seen_right), read(walls.seen_left, j, seen_left);
        read(walls.seen_bottom, j, seen_bottom), read(walls.seen_top, j, seen_top);
        const Floats model_weight = none + m.weight;
        weight = weight < model_weight ? weight : model_weight;
        Ints overlaps;
        Floats edges;
        overlapInHeight(bottom, top, m, overlaps);
        countEdges(m_bottom - seen_bottom, m_top - seen_top, edges);
        weight = overlaps ? weight : none;
        Floats bin = along * (m.offset - offset) + kMiddle, right = across * (m_right - seen_right) + kMiddle,
               left = across * (m_left - seen_left) + kMiddle;
        bound(bin), bound(right), bound(left);
        const Floats wall_weight = weight * (1 + kEdge * edges), end_weight = kEnd * weight;
        const Ints bins = __builtin_convertvector(bin, Ints), rights = __builtin_convertvector(right, Ints),
                   lefts = __builtin_convertvector(left, Ints);
        const int n = end - j < kLanes ? end - j : kLanes;
        for (int lane = 0; lane < n; ++lane) {
          by_wall[static_cast<std::size_t>(bins[lane])] += wall_weight[lane];
          by_end[static_cast<std::size_t>(rights[lane])] += end_weight[lane];
          by_end[static_cast<std::size_t>(lefts[lane])] += end_weight[lane];
        }
      }
    }
  }
  return most(votes[0]) + most(votes[1]);
}

}  // namespace

Prescore::Prescore(const PlaceDescriptor& scene) : scene_(scene), walls_(scene.walls) {}

float Prescore::of(const PlaceDescriptor& model) const {
  float best = 0;
  const float least_turn = model.main_heading - scene_.main_heading;
  for (int quarters = -2; quarters < 2; ++quarters) {
    const float turn = wrapped(least_turn + kQuarter * static_cast<float>(quarters));
    if (std::abs(turn) > kLargestTurn) continue;
    best = std::max(best, bestMoves(scene_, walls_, model, quarters) - kTurnPrior * turn * turn);
  }
  for (const LevelSurface& a : scene_.surfaces)
    best += kSurface * std::any_of(model.surfaces.begin(), model.surfaces.end(), [&a](const LevelSurface& b) {
              return a.from_below == b.from_below && std::abs(a.height - b.height) < kHeightError;
            });
  float total = kBaseWeight;
  for (const Wall& w : model.walls) total += w.weight;
  return best / std::pow(total, kPower);
}

}  // namespace facetloc::internal
