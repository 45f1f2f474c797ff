// SPDX-License-Identifier: BSD-3-Clause
#include "hall_floor.h"

namespace facetloc {
namespace {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;

}  // namespace

void HallFloor::buildRack(double y, double yaw, Random& random) {
  const Spot spot{{(racks_west_ + racks_east_) / 2, y}, yaw};
  addRackRow(builder_, spot, rack_, random);
  plan_.take({spot, rack_.depth + 0.05, rack_.length + 0.1});
}

void HallFloor::addGuard(double x, double y, double width) {
  constexpr double kHeight = 0.4, kThickness = 0.1;
  const Spot spot{{x, y}, 0};
  builder_.box(spot.relative(0, 0, 0, kHeight - 0.15), {kThickness, width, 0.15});
  for (const int side : {-1, 1})
    builder_.box(spot.relative(0, side * (width / 2 - 0.1)), {0.08, 0.1, kHeight - 0.15});
  plan_.take({spot, kThickness, width});
}

void HallFloor::buildRacks() {
  Random random(derivedSeed(seed_, kRacks));
  buildRack(0.1 + rack_.depth / 2, kPi / 2, random);
  constexpr double kGuardGap = 0.25;
  for (const double row : rows_) {
    const double half = (rack_.depth + kBackToBack) / 2;
    buildRack(row - half, -kPi / 2, random);
    buildRack(row + half, kPi / 2, random);
    for (const double x : {racks_west_ - kGuardGap, racks_east_ + kGuardGap})
      addGuard(x, row, 2 * rack_.depth + kBackToBack);
  }
}

AlignedBox2d HallFloor::openArea() const {
  constexpr double kOffRacks = 0.4;
  return {Vector2d(racks_east_ + kOffRacks, 0), hall_.max()};
}

void HallFloor::addPalletBlock(const Vector2d& corner, int columns, int lines) {
  constexpr double kAlong = 1.45, kAcross = 1.0, kShareEmpty = 0.25;
  for (int i = 0; i < columns; ++i) {
    for (int j = 0; j < lines; ++j) {
      if (random_.uniform() < kShareEmpty) continue;
      const Spot spot{corner + Vector2d((i + 0.5) * kAlong, (j + 0.5) * kAcross), 0};
      furnisher_.at(kind::kPallet, spot, openArea(), true, 0.06, 4);
    }
  }
}

void HallFloor::furnishOpenArea() {
  const AlignedBox2d area = openArea();
  // Machines go along the walls, most of them in the north; pallets on the island inside the loop.
  const AlignedBox2d north(Vector2d(0.5, aisle_3_ + 1.2), hall_.max());
  for (int i = count(1, 2); i > 0; --i) furnisher_.atWall(kind::kMachine, north, false, 8);
  for (int i = count(2, 3); i > 0; --i) furnisher_.atWall(kind::kMachine, hall_, false, 3);
  for (int i = count(2, 3); i > 0; --i) furnisher_.atWall(kind::kWorkbench, hall_);
  furnisher_.anywhere(kind::kForklift, area);
  addPalletBlock({racks_east_ + 2.6, aisle_2_ + 0.9}, 3, 3);
  addPalletBlock({hall_.max().x() - 1.6, store_.max().y() + 0.3}, 1, 8);
  addPalletBlock({racks_east_ + 2.4, 0.4}, 2, 2);
  for (int i = count(1, 2); i > 0; --i) furnisher_.anywhere(kind::kMachine, area, false);
  for (int i = count(3, 5); i > 0; --i) furnisher_.anywhere(kind::kPallet, area);
  for (int i = count(2, 3); i > 0; --i) furnisher_.anywhere(kind::kTrolley, area);
  furnisher_.anywhere(kind::kStepladder, area);
  furnisher_.atWall(kind::kBarrels, hall_, true, 10);
  for (int i = count(2, 3); i > 0; --i) furnisher_.atWall(kind::kLocker, hall_);
  furnisher_.atWall(kind::kWorkbench, hall_);
  for (int i = count(4, 7); i > 0; --i) furnisher_.anywhere(kind::kCarton, area);
  for (int i = count(2, 4); i > 0; --i) furnisher_.atWall(kind::kBin, hall_, true, 15);
}

void HallFloor::furnishAisles() {
  const AlignedBox2d west(Vector2d(0, 0), Vector2d(racks_west_, hall_.max().y()));
  for (int i = count(1, 2); i > 0; --i) furnisher_.atWall(kind::kCupboard, west);
  for (int i = count(2, 4); i > 0; --i) furnisher_.anywhere(kind::kCarton, west);
  furnisher_.anywhere(kind::kPallet, west);
  const AlignedBox2d aisles(Vector2d(racks_west_, 1), Vector2d(racks_east_, hall_.max().y()));
  for (const Kind* kind :
       {&kind::kTrolley, &kind::kStepladder, &kind::kCarton, &kind::kCarton, &kind::kPallet})
    furnisher_.anywhere(*kind, aisles);
}

void HallFloor::furnishStoreRoom() {
  const AlignedBox2d room(store_.min() + Vector2d(kInnerWall / 2, 0),
                          store_.max() - Vector2d(0, kInnerWall / 2));
  for (int i = count(2, 3); i > 0; --i) furnisher_.atWall(kind::kBookcase, room);
  furnisher_.atWall(kind::kWorkbench, room);
  furnisher_.atWall(kind::kCupboard, room);
  furnisher_.atWall(kind::kLocker, room);
  furnisher_.atWall(kind::kBarrels, room, false, 20);
  furnisher_.anywhere(kind::kPallet, room);
  for (int i = count(2, 4); i > 0; --i) furnisher_.anywhere(kind::kCarton, room);
  plan_.take({Spot{room.center(), 0}, room.sizes().x(), room.sizes().y()});  // nothing else goes there
}

void HallFloor::addFixtures() {
  for (int i = count(16, 22); i > 0; --i) {
    const double draw = random_.uniform();
    const double width = random_.uniform(0.4, 1.2), height = random_.uniform(0.4, 1.0);
    const double z = random_.uniform(0.7, 1.4);
    const auto spot = furnisher_.onWall(hall_, width, z);
    if (!spot) continue;
    if (draw < 0.35) {
      addPicture(builder_, *spot, width, height);
    } else if (draw < 0.75) {
      builder_.box(spot->relative(0.12, 0), {0.24, 0.7 * width, height});
    } else {
      builder_.cylinder(spot->relative(0.12, 0), 0.08, 0.5);
    }
  }
}

void HallFloor::addPeople() {
  for (const When when : {When::mapped, When::later})
    for (int i = count(2, 4); i > 0; --i) furnisher_.passing(kind::kPerson, hall_, when);
}

}  // namespace facetloc
