// SPDX-License-Identifier: BSD-3-Clause
// A floor without walls: with boards that lie about, or one box that looks the same after half a turn.
#include "floor_plan.h"
#include "scene_builder.h"

#include <facetloc/features/pose.h>

#include <Eigen/Geometry>

#include <cmath>

namespace facetloc {
namespace {

using Eigen::Vector2d;

// Sizes [m].
constexpr double kHalfFloor = 6, kHalfArea = 1.6;
constexpr double kShortest = 0.15, kLongest = 0.6, kNarrowest = 0.1, kWidest = 0.35;
constexpr double kThinnest = 0.012, kThickest = 0.03;
constexpr int kBoards = 24;
constexpr double kHalfRound = 0.9;  // half the side of the robot's path among boards
constexpr double kRadius = 1.8;     // radius of its path around the box
constexpr double kOff = 0.25;       // offset of the later run
constexpr int kCorners = 8;         // corners of the way around the box

const Eigen::AlignedBox2d kFloor(Vector2d::Constant(-kHalfFloor), Vector2d::Constant(kHalfFloor));

void addBoard(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const double length = random.uniform(kShortest, kLongest), width = random.uniform(kNarrowest, kWidest);
  builder.box(spot, {length, width, random.uniform(kThinnest, kThickest)}, when);
}

/** A square, with a look around at each corner. */
Route squareRoute(double half, double look_deg) {
  return {{{-half, -half}, look_deg},
          {{half, -half}, look_deg},
          {{half, half}, look_deg},
          {{-half, half}, look_deg}};
}

/** Once around; at each corner the robot looks at the box. */
Route wayAround(double radius) {
  constexpr double kCorner = 360.0 / kCorners;
  Route route;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = i * kCorner * kDegree;
    route.push_back({{radius * std::cos(angle), radius * std::sin(angle)}, 90 + kCorner / 2});
  }
  return route;
}

}  // namespace

SimulatedPlace bareFloor(std::uint64_t seed) {
  Random random(seed);
  SimulatedPlace place;
  SceneBuilder builder(place);
  builder.level(kFloor, 0);
  FloorPlan plan;
  Furnisher furnisher(builder, plan, random);
  const Eigen::AlignedBox2d area(Vector2d::Constant(-kHalfArea), Vector2d::Constant(kHalfArea));
  for (int i = 0; i < kBoards; ++i) furnisher.anywhere({addBoard, kLongest, kWidest}, area, false);
  place.mapping_route = squareRoute(kHalfRound, 180);
  place.query_route = squareRoute(kHalfRound + random.uniform(-kOff, kOff), -180);
  return place;
}

SimulatedPlace symmetricBox(std::uint64_t seed) {
  Random random(seed);
  SimulatedPlace place;
  SceneBuilder builder(place);
  builder.level(kFloor, 0);
  const double length = random.uniform(0.9, 1.4), width = random.uniform(0.4, 0.7);
  const double height = random.uniform(0.7, 1.1);
  const Spot middle{{0, 0}, random.uniform(-180, 180) * kDegree};
  builder.box(middle, {length, width, height});
  // Parts that stand out look the same after half a turn: a lid, and a ledge on both long sides.
  builder.box(middle.relative(0, 0, 0, height), {length / 2, width / 2, random.uniform(0.1, 0.2)});
  const double ledge = random.uniform(0.1, 0.2), ledge_height = random.uniform(0.2, 0.4);
  for (const double side : {-1, 1})
    builder.box(middle.relative(0, side * (width + ledge) / 2), {length / 2, ledge, ledge_height});
  place.mapping_route = wayAround(kRadius);
  place.query_route = wayAround(kRadius + random.uniform(-kOff, kOff));
  return place;
}

}  // namespace facetloc
