// SPDX-License-Identifier: BSD-3-Clause
#include "floor_plan.h"
#include "scene_builder.h"

#include <Eigen/Geometry>

namespace facetloc {
namespace {

using Eigen::Vector2d;

// Sizes [m].
constexpr double kHalfFloor = 6, kHalfArea = 1.6;
constexpr double kShortest = 0.15, kLongest = 0.6, kNarrowest = 0.1, kWidest = 0.35;
constexpr double kThinnest = 0.012, kThickest = 0.03;
constexpr int kBoards = 24;
constexpr double kHalfRound = 0.9;  // half the side of the robot's path
constexpr double kOffRound = 0.25;  // offset of the later run

void addBoard(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const double length = random.uniform(kShortest, kLongest), width = random.uniform(kNarrowest, kWidest);
  builder.box(spot, {length, width, random.uniform(kThinnest, kThickest)}, when);
}

/** A square, with a look around at each corner. */
Route wayAround(double half, double look_deg) {
  return {{{-half, -half}, look_deg},
          {{half, -half}, look_deg},
          {{half, half}, look_deg},
          {{-half, half}, look_deg}};
}

}  // namespace

SimulatedPlace bareFloor(std::uint64_t seed) {
  Random random(seed);
  SimulatedPlace place;
  SceneBuilder builder(place);
  builder.level({Vector2d::Constant(-kHalfFloor), Vector2d::Constant(kHalfFloor)}, 0);
  FloorPlan plan;
  Furnisher furnisher(builder, plan, random);
  const Eigen::AlignedBox2d area(Vector2d::Constant(-kHalfArea), Vector2d::Constant(kHalfArea));
  for (int i = 0; i < kBoards; ++i) furnisher.anywhere({addBoard, kLongest, kWidest}, area, false);
  place.mapping_route = wayAround(kHalfRound, 180);
  place.query_route = wayAround(kHalfRound + random.uniform(-kOffRound, kOffRound), -180);
  return place;
}

}  // namespace facetloc
