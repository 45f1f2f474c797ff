// SPDX-License-Identifier: BSD-3-Clause
#include "home_floor.h"

#include <utility>

namespace facetloc {
namespace {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;

}  // namespace

void HomeFloor::addPictures(const AlignedBox2d& room, int number) {
  for (int i = 0; i < number; ++i) {
    const double width = random_.uniform(0.3, 1.1), height = random_.uniform(0.3, 0.75);
    const double z = random_.uniform(1.15, 1.6);
    const bool shelf = random_.uniform() < 0.3;
    if (const auto spot = furnisher_.onWall(room, width, z)) {
      if (shelf) {
        addWallShelf(builder_, *spot, width, random_);
      } else {
        addPicture(builder_, *spot, width, height);
      }
    }
  }
}

void HomeFloor::addChairs(const Kind& kind, const Spot& table, const AlignedBox2d& room, int number,
                          bool both_sides) {
  constexpr double kOff = 0.34;  // middle of a chair to the edge of the table
  for (int i = 0; i < number; ++i) {
    const int side = both_sides && i % 2 ? -1 : 1;
    const int in_row = both_sides ? i / 2 : i;
    const double y = (in_row ? 0.36 : -0.36) * (both_sides ? 1 : 0);
    const Spot spot = table.relative(side * (kind.depth / 2 + kOff), y, side > 0 ? kPi : 0);
    furnisher_.at(kind::kChair, spot, room, true, 0.03, 25);
  }
}

void HomeFloor::addDiningTable(const AlignedBox2d& room) {
  const bool round = random_.uniform() < 0.35;
  const Kind& kind = round ? kind::kRoundTable : kind::kTable;
  constexpr double kAtWall = 0.5;  // some tables stand with one side at the wall
  const auto table =
      random_.uniform() < kAtWall ? furnisher_.atWall(kind, room) : furnisher_.anywhere(kind, room, false);
  if (!table) return;
  addChairs(kind, *table, room, count(2, 4), true);
  if (random_.uniform() < 0.6) addPendantLamp(builder_, *table, kCeiling, random_);
}

void HomeFloor::addSmallThings(const AlignedBox2d& room, int number) {
  for (int i = 0; i < number; ++i) {
    const double draw = random_.uniform();
    const Kind& kind = draw < 0.35   ? kind::kPlant
                       : draw < 0.55 ? kind::kLamp
                       : draw < 0.75 ? kind::kBin
                                     : kind::kCarton;
    furnisher_.atWall(kind, room, true, 20);
  }
}

void HomeFloor::furnishLivingRoom() {
  const AlignedBox2d& room = living_room_;
  const auto sofa = furnisher_.atWall(kind::kSofa, room, false, 6);
  if (sofa) {
    constexpr double kFar = 0.85;  // distance between the middles of the sofa and the table before it
    furnisher_.at(kind::kCoffeeTable, sofa->relative(kFar + 0.1, 0), room, true, 0.1, 15);
  }
  furnisher_.atWall(kind::kTvStand, room);
  furnisher_.atWall(kind::kBookcase, room);
  addDiningTable(room);
  furnisher_.atWall(random_.uniform() < 0.5 ? kind::kSideboard : kind::kCupboard, room);
  for (int i = count(1, 2); i > 0; --i) furnisher_.anywhere(kind::kArmchair, room);
  furnisher_.atWall(kind::kBookcase, room);
  addSmallThings(room, count(3, 5));
  addPictures(room, count(3, 5));
}

void HomeFloor::furnishKitchen() {
  const AlignedBox2d& room = kitchen_room_;
  // The unit stands in the middle of the north wall or in one of its corners.
  const double slack = (room.sizes().x() - kind::kKitchenUnit.width) / 2 - kind::kFridge.width - 0.05;
  const double x = room.center().x() + random_.uniform(-slack, slack);
  const Spot unit{{x, room.max().y() - kind::kKitchenUnit.depth / 2 - 0.005}, -kPi / 2};
  if (furnisher_.at(kind::kKitchenUnit, unit, room)) {
    const int first = random_.uniform() < 0.5 ? 1 : -1;
    const double beside = (kind::kKitchenUnit.width + kind::kFridge.width + 0.03) / 2;
    for (const int side : {first, -first})
      if (furnisher_.at(kind::kFridge, unit.relative(0, side * beside), room)) break;
  }
  addDiningTable(room);
  furnisher_.atWall(kind::kCupboard, room);
  furnisher_.atWall(kind::kSideboard, room);
  addSmallThings(room, count(2, 4));
  addPictures(room, count(2, 4));
}

void HomeFloor::furnishBedrooms() {
  for (const AlignedBox2d& room : {bedroom_a_, bedroom_b_}) {
    const auto bed = furnisher_.atWall(kind::kBed, room);
    furnisher_.atWall(kind::kWardrobe, room);
    if (bed) {
      const double x = -(kind::kBed.depth - kind::kBedsideTable.depth) / 2;
      const double y = (kind::kBed.width + kind::kBedsideTable.width) / 2 + 0.03;
      for (const int side : {-1, 1}) furnisher_.at(kind::kBedsideTable, bed->relative(x, side * y), room);
    }
  }
  for (const AlignedBox2d& room : {bedroom_a_, bedroom_b_}) {
    const bool works = random_.uniform() < 0.6;
    const Kind& kind = works ? kind::kDesk : kind::kSideboard;
    if (const auto desk = furnisher_.atWall(kind, room); desk && works)
      addChairs(kind::kDesk, *desk, room, 1, false);
    furnisher_.atWall(kind::kBookcase, room);
    addSmallThings(room, count(2, 4));
    addPictures(room, count(2, 4));
  }
}

void HomeFloor::furnishBath() {
  const AlignedBox2d& room = bath_room_;
  for (const Kind* kind :
       {&kind::kBathtub, &kind::kWashbasin, &kind::kToilet, &kind::kWashingMachine, &kind::kShoeCupboard})
    furnisher_.atWall(*kind, room);
  furnisher_.atWall(kind::kBin, room, true);
  addPictures(room, count(1, 2));
}

void HomeFloor::furnishHallway() {
  for (const Kind* kind : {&kind::kShoeCupboard, &kind::kRadiator, &kind::kCoats, &kind::kRadiator})
    furnisher_.atWall(*kind, hallway_);
  if (random_.uniform() < 0.5) furnisher_.atWall(kind::kShoeCupboard, hallway_);
  furnisher_.atWall(kind::kBin, hallway_, true, 20);
  addPictures(hallway_, count(3, 5));
}

void HomeFloor::furnishStudy() {
  const AlignedBox2d& room = study_;
  if (const auto desk = furnisher_.atWall(kind::kDesk, room)) addChairs(kind::kDesk, *desk, room, 1, false);
  furnisher_.atWall(kind::kBookcase, room);
  furnisher_.atWall(kind::kCupboard, room);
  furnisher_.atWall(kind::kBookcase, room);
  furnisher_.anywhere(kind::kArmchair, room);
  addSmallThings(room, count(2, 3));
  addPictures(room, count(2, 3));
}

void HomeFloor::addRadiators() {
  const double reach = kind::kRadiator.width;
  for (const Spot& window : windows_) {
    const Spot spot = window.relative(kind::kRadiator.depth / 2 + 0.001, 0);
    const AlignedBox2d around(spot.place - Vector2d(reach, reach), spot.place + Vector2d(reach, reach));
    furnisher_.at(kind::kRadiator, spot, around);
  }
}

void HomeFloor::addPeople() {
  const std::pair<const AlignedBox2d*, When> people[] = {{&living_room_, When::mapped},
                                                         {&kitchen_room_, When::mapped},
                                                         {&living_room_, When::later},
                                                         {&kitchen_room_, When::later},
                                                         {&bedroom_b_, When::later}};
  for (const auto& [room, when] : people) {
    const bool there = random_.uniform() < 0.6;
    if (there) furnisher_.passing(kind::kPerson, *room, when);
  }
}

}  // namespace facetloc
