// SPDX-License-Identifier: BSD-3-Clause
// Corridors, a bare one and one of equal doors, and floors without walls: with boards that lie about, or one
// box that looks the same after half a turn.
#include "floor_plan.h"
#include "scene_builder.h"

#include <facetloc/features/pose.h>

#include <Eigen/Geometry>

#include <cmath>
#include <vector>

namespace facetloc {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kFromEnd = 1;               // distance of the robot from the ends [m]
constexpr double kThingsOfADoor = 3.0 / 16;  // one side counts
// Sizes between doors [m].
constexpr double kSpacing = 1.8;
constexpr double kHalfWidth = 1.2, kHeight = 2.6, kWall = 0.24;
constexpr double kDoor = 0.9, kDoorHeight = 2.05, kLeaf = 0.04;
constexpr double kThingDepth = 0.3;

double middleOf(int door) { return (door + 0.5) * kSpacing; }

/** A wall with its doors, closed and set back by half of its thickness. */
void addSide(SceneBuilder& builder, int n_doors, double side) {
  std::vector<Opening> doors;
  for (int door = 0; door < n_doors; ++door) doors.push_back({middleOf(door), kDoor, 0, kDoorHeight});
  builder.wall({0, side * kHalfWidth}, {n_doors * kSpacing, side * kHalfWidth}, kWall, kHeight, doors);
  for (int door = 0; door < n_doors; ++door)
    builder.box(Spot{{middleOf(door), side * kHalfWidth}}, {kDoor, kLeaf, kDoorHeight});
}

/** Between two doors, at one of the walls. */
void addThing(SceneBuilder& builder, int n_doors, Random& random) {
  const double side = random.uniform() < 0.5 ? -1 : 1;
  const double x = (1 + static_cast<int>((n_doors - 1) * random.uniform())) * kSpacing;
  const double length = random.uniform(0.4, 0.8), height = random.uniform(0.5, 1.8);
  builder.box(Spot{{x, side * (kHalfWidth - (kWall + kThingDepth) / 2)}}, {length, kThingDepth, height});
}

/** Both runs go from end to end, each on a line that is not quite the corridor's. */
void driveThrough(double length, double off_middle, Random& random, SimulatedPlace& place) {
  for (Route* route : {&place.mapping_route, &place.query_route}) {
    const double from = random.uniform(-off_middle, off_middle), to = random.uniform(-off_middle, off_middle);
    *route = {{{kFromEnd, from}, 0}, {{length - kFromEnd, to}, 0}};
  }
  place.one_way = true;
}

// Sizes of floors without walls [m].
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

SimulatedPlace bareCorridor(std::uint64_t seed) {
  constexpr double kLength = 40;  // [m]
  Random random(seed);
  SimulatedPlace place;
  SceneBuilder builder(place);
  const double half_width = random.uniform(1.8, 2.2) / 2;
  const double height = random.uniform(2.4, 3.0);
  const Eigen::AlignedBox2d area(Vector2d(0, -half_width), Vector2d(kLength, half_width));
  builder.level(area, 0);
  builder.level(area, height);
  const Vector3d along(kLength / 2, 0, 0), across(0, half_width, 0), up(0, 0, height / 2);
  for (const double side : {-1, 1}) builder.rectangle(along + up + side * across, along, up);
  for (const double side : {-1, 1}) builder.rectangle(along + up + side * along, across, up);
  driveThrough(kLength, 0.3, random, place);
  return place;
}

SimulatedPlace equalDoors(std::uint64_t seed, int n_doors) {
  const double length = n_doors * kSpacing;
  Random random(seed);
  SimulatedPlace place;
  SceneBuilder builder(place);
  const Eigen::AlignedBox2d area(Vector2d(0, -kHalfWidth), Vector2d(length, kHalfWidth));
  builder.level(area, 0);
  builder.level(area, kHeight);
  for (const double side : {-1, 1}) addSide(builder, n_doors, side);
  for (const double x : {0.0, length}) builder.wall({x, -kHalfWidth}, {x, kHalfWidth}, kWall, kHeight);
  for (int i = 0; i < kThingsOfADoor * n_doors; ++i) addThing(builder, n_doors, random);
  driveThrough(length, 0.2, random, place);
  return place;
}

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
