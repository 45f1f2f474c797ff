// SPDX-License-Identifier: BSD-3-Clause
#include "scene_builder.h"

#include <facetloc/features/pose.h>

#include <cmath>

namespace facetloc {
namespace {

using Eigen::Vector2d;

constexpr int kCorners = 8;  // corners of the way around the box
// Sizes [m].
constexpr double kHalfFloor = 6;
constexpr double kRadius = 1.8, kOffRadius = 0.25;

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

SimulatedPlace symmetricBox(std::uint64_t seed) {
  Random random(seed);
  SimulatedPlace place;
  SceneBuilder builder(place);
  builder.level({Vector2d::Constant(-kHalfFloor), Vector2d::Constant(kHalfFloor)}, 0);
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
  place.query_route = wayAround(kRadius + random.uniform(-kOffRadius, kOffRadius));
  return place;
}

}  // namespace facetloc
