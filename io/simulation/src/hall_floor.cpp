// SPDX-License-Identifier: BSD-3-Clause
#include "hall_floor.h"

#include <utility>

namespace facetloc {
namespace {

using Eigen::Vector2d;

constexpr int kBays = 4;

}  // namespace

SimulatedPlace HallFloor::build() {
  drawSizes();
  drawRoutes();
  buildWalls();
  buildStoreRoom();
  buildRacks();
  buildColumns();
  buildBeams();
  furnishStoreRoom();
  furnishOpenArea();
  furnishAisles();
  addFixtures();
  addPeople();
  place_.unmapped_rooms = {store_};
  if (mirrored_) mirror(place_, hall_.max().x());
  return std::move(place_);
}

void HallFloor::drawSizes() {
  Random random(derivedSeed(seed_, kSizes));
  const double width = random.uniform(23.5, 24.5), depth = random.uniform(15.6, 16.4);
  hall_ = {Vector2d(0, 0), Vector2d(width, depth)};
  ceiling_ = random.uniform(5.0, 6.0);
  rack_.depth = random.uniform(0.8, 1.0);
  rack_.length = kBays * random.uniform(2.0, 2.3);
  rack_.bays = kBays;
  rack_.height = random.uniform(3.0, 3.8);
  rack_.board_distance = random.uniform(0.55, 0.85);
  racks_west_ = random.uniform(2.7, 3.0);
  racks_east_ = racks_west_ + rack_.length;
  const double row = 2 * rack_.depth + kBackToBack;
  constexpr double kOffWall = 0.1;
  double y = kOffWall + rack_.depth;
  for (double* aisle : {&aisle_1_, &aisle_2_}) {
    const double wide = random.uniform(2.45, 2.85);
    *aisle = y + wide / 2;
    y += wide;
    rows_.push_back(y + row / 2);
    y += row;
  }
  aisle_3_ = y + 1.4;
  store_ = {Vector2d(width - random.uniform(5.4, 6.0), 0), Vector2d(width, random.uniform(4.0, 4.5))};
  mirrored_ = random.uniform() < 0.5;
  store_west_door_ = random.uniform(1.9, 2.3);
  store_north_door_ = width - random.uniform(2.5, 2.9);
}

void HallFloor::drawRoutes() {
  Random random(derivedSeed(seed_, kWays));
  const auto near = [&](double x, double y, double spread = 0.2) {
    const double dx = random.uniform(-spread, spread), dy = random.uniform(-spread, spread);
    return Waypoint{{x + dx, y + dy}, 0};
  };
  const double west = racks_west_ / 2, east = racks_east_ + 1.2;
  const double off = random.uniform(0.1, 0.25),
               other = -random.uniform(0.1, 0.25);  // offset from the middle of aisles
  const double loop_east = store_north_door_, loop_south = aisle_2_ - 0.1, loop_north = aisle_3_ + 0.9;

  constexpr double kStraight = 0.05;  // aisles are driven along straight lines, nearly
  Route& mapping = place_.mapping_route;
  mapping = {near(east, aisle_1_ + off, kStraight),
             near(west, aisle_1_ + off, kStraight),
             near(west, aisle_2_ + off, kStraight),
             near(east, aisle_2_ + off, kStraight),
             near(loop_east - 2.0, loop_south - 0.3),
             near(loop_east, loop_south + 1.6),
             near(loop_east - 0.2, loop_north - 0.8),
             near(loop_east - 2.4, loop_north),
             near(east + 0.5, aisle_3_ + off, kStraight),
             near(west, aisle_3_ + off, kStraight),
             near(west - 0.1, aisle_1_ + off - 0.2, kStraight)};
  Route& query = place_.query_route;
  query = {near(west + 0.3, aisle_2_ + other, kStraight),
           near(east + 0.4, aisle_2_ + other, kStraight),
           near(store_.min().x() - 1.2, store_west_door_, kStraight),
           near(store_.min().x() + 1.1, store_west_door_, kStraight),
           near(store_north_door_, store_.max().y() - 0.9, kStraight),
           near(store_north_door_, store_.max().y() + 1.0, kStraight),
           near(loop_east - 0.3, loop_south + 1.8),
           near(loop_east + 0.15, loop_north - 0.6),
           near(loop_east - 2.0, loop_north + 0.3),
           near(east, aisle_3_ + other, kStraight),
           near(west + 0.3, aisle_3_ + other, kStraight),
           near(west + 0.3, aisle_1_ + other, kStraight),
           near(east + 0.3, aisle_1_ + other, kStraight),
           near(east + 0.3, aisle_2_ - 0.6, kStraight)};
  plan_.keepFree(mapping);
  plan_.keepFree(query);
}

SimulatedPlace hallFloor(std::uint64_t seed) { return HallFloor(seed).build(); }

}  // namespace facetloc
