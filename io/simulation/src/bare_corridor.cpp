// SPDX-License-Identifier: BSD-3-Clause
#include "scene_builder.h"

#include <Eigen/Geometry>

namespace facetloc {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Sizes, and the robot's distance from the middle line and from the ends [m].
constexpr double kLength = 40;
constexpr double kNarrowest = 1.8, kWidest = 2.2;
constexpr double kLowest = 2.4, kHighest = 3.0;
constexpr double kOffMiddle = 0.3;
constexpr double kFromEnd = 1;

/** Route from end to end, on a line that is not quite the corridor's. */
Route wayThrough(Random& random) {
  const double from = random.uniform(-kOffMiddle, kOffMiddle), to = random.uniform(-kOffMiddle, kOffMiddle);
  return {{{kFromEnd, from}, 0}, {{kLength - kFromEnd, to}, 0}};
}

}  // namespace

SimulatedPlace bareCorridor(std::uint64_t seed) {
  Random random(seed);
  SimulatedPlace place;
  SceneBuilder builder(place);
  const double half_width = random.uniform(kNarrowest, kWidest) / 2;
  const double height = random.uniform(kLowest, kHighest);
  const Eigen::AlignedBox2d area(Vector2d(0, -half_width), Vector2d(kLength, half_width));
  builder.level(area, 0);
  builder.level(area, height);
  const Vector3d along(kLength / 2, 0, 0), across(0, half_width, 0), up(0, 0, height / 2);
  for (const double side : {-1, 1}) builder.rectangle(along + up + side * across, along, up);
  for (const double side : {-1, 1}) builder.rectangle(along + up + side * along, across, up);
  place.mapping_route = wayThrough(random);
  place.query_route = wayThrough(random);
  place.one_way = true;
  return place;
}

}  // namespace facetloc
