// SPDX-License-Identifier: BSD-3-Clause
#include "home_floor.h"

#include <utility>

namespace facetloc {
namespace {

using Eigen::Vector2d;

// Middle of a bedroom's door to the line of the wall beside it [m].
constexpr double kDoorFromCorner = 0.85;

}  // namespace

SimulatedPlace HomeFloor::build() {
  drawSizes();
  drawRoutes();
  buildOuterWalls();
  buildInnerWalls();
  buildDoors();
  addShaft({0, kitchen_ - kWall / 2}, {1, -1});
  addShaft({width_, depth_}, {-1, -1});
  furnishLivingRoom();
  furnishKitchen();
  furnishBedrooms();
  furnishBath();
  furnishHallway();
  furnishStudy();
  addRadiators();
  addPeople();
  place_.unmapped_rooms = {study_};
  if (mirrored_) mirror(place_, width_);
  return std::move(place_);
}

void HomeFloor::drawSizes() {
  Random random(derivedSeed(seed_, kSizes));
  width_ = random.uniform(11.4, 12.0);
  depth_ = random.uniform(9.3, 9.8);
  west_ = random.uniform(4.7, 5.1);
  south_ = random.uniform(3.7, 3.95);
  north_ = south_ + kHallwayWidth;
  between_bedrooms_ = (west_ + width_ + kWall / 2) / 2;
  kitchen_ = north_ + random.uniform(-0.3, 0.1);
  door_a_ = west_ + kDoorFromCorner;
  door_b_ = between_bedrooms_ + kDoorFromCorner;
  bath_ = door_b_ - random.uniform(1.0, 1.2);
  study_door_ = random.uniform(west_ + 1.5, bath_ - 1.2);
  pantry_door_ = north_ + random.uniform(1.25, 1.6);
  kitchen_opening_ = random.uniform(1.5, 2.0);
  mirrored_ = random.uniform() < 0.5;
  const double half = kWall / 2;
  living_room_ = {Vector2d(0, 0), Vector2d(west_ - half, kitchen_ - half)};
  kitchen_room_ = {Vector2d(0, kitchen_ + half), Vector2d(west_ - half, depth_)};
  hallway_ = {Vector2d(west_ + half, south_ + half), Vector2d(width_, north_ - half)};
  bedroom_a_ = {Vector2d(west_ + half, 0), Vector2d(between_bedrooms_ - half, south_ - half)};
  bedroom_b_ = {Vector2d(between_bedrooms_ + half, 0), Vector2d(width_, south_ - half)};
  study_ = {Vector2d(west_ + half, north_ + half), Vector2d(bath_ - half, depth_)};
  bath_room_ = {Vector2d(bath_ + half, north_ + half), Vector2d(width_, depth_)};
}

void HomeFloor::drawRoutes() {
  Random random(derivedSeed(seed_, kWays));
  const auto within = [&](double spread, double x, double y) {
    const double dx = random.uniform(-spread, spread), dy = random.uniform(-spread, spread);
    return Waypoint{{x + dx, y + dy}, 0};
  };
  const auto near = [&](double x, double y) { return within(0.12, x, y); };
  const auto in_door = [&](double x, double y) { return within(0.04, x, y); };
  const double middle = (south_ + north_) / 2;
  const double lane = middle - random.uniform(0.02, 0.08);
  const double south_door = south_ - 0.55, north_door = north_ + 0.55;

  Route& mapping = place_.mapping_route;
  mapping = {near(west_ - 1.2, lane),
             near(2.9, middle - 0.9),
             near(2.3, 2.2),
             near(kitchen_opening_ - 0.1, kitchen_ - 0.8),
             near(kitchen_opening_ - 0.1, kitchen_ + 0.8),
             near(2.9, kitchen_ + 1.6),
             near(kitchen_opening_ + 0.1, kitchen_ + 0.7),
             near(kitchen_opening_ + 0.1, kitchen_ - 0.7),
             near(west_ - 0.9, lane),
             {{door_a_, lane}, 0},
             in_door(door_a_, south_door),
             near(door_a_ + 0.6, south_ - 1.5),
             in_door(door_a_, south_door),
             {{door_a_, lane}, 0},
             {{door_b_, lane}, 0},
             in_door(door_b_, south_door),
             near(door_b_ + 0.6, south_ - 1.5),
             in_door(door_b_, south_door),
             in_door(door_b_, north_door),
             near(door_b_ + 0.2, north_ + 1.3),
             in_door(door_b_, north_door),
             {{door_b_, lane}, 0},
             {{west_, lane}, 0}};

  const double other_lane = lane + random.uniform(0.2, 0.28);
  Route& query = place_.query_route;
  query = {{{width_ - 1.0, other_lane}, 0},
           {{study_door_, other_lane}, 0},
           in_door(study_door_, north_door),
           in_door(west_ + 0.6, pantry_door_),
           in_door(west_ - 0.6, pantry_door_),
           near(kitchen_opening_ + 0.35, kitchen_ + 1.5),
           near(kitchen_opening_ + 0.1, kitchen_ - 0.6),
           near(1.7, 2.6),
           near(3.1, 2.4),
           near(west_ - 0.8, other_lane),
           {{door_a_, other_lane}, 0},
           in_door(door_a_, south_door),
           near(door_a_ + 0.25, south_ - 1.6),
           in_door(door_a_, south_door),
           {{door_a_, other_lane}, 0},
           {{door_b_, other_lane}, 0},
           in_door(door_b_, south_door),
           near(door_b_ + 0.25, south_ - 1.6),
           in_door(door_b_, south_door),
           {{door_b_, other_lane}, 0}};
  plan_.keepFree(mapping);
  plan_.keepFree(query);
}

SimulatedPlace homeFloor(std::uint64_t seed) { return HomeFloor(seed).build(); }

}  // namespace facetloc
