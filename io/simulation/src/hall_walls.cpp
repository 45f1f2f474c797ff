// SPDX-License-Identifier: BSD-3-Clause
#include "hall_floor.h"

#include <cmath>
#include <vector>

namespace facetloc {
namespace {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;

// Lengths in metres.
constexpr double kWall = 0.3;  // thickness
constexpr double kStoreHeight = 2.8;
constexpr double kDoorWidth = 1.1, kDoorHeight = 2.1, kLeafHeight = 2.08;
constexpr double kGateWidth = 3.2, kGateHeight = 3.6;

}  // namespace

void HallFloor::buildGate(const Spot& inside) {
  constexpr int kSlats = 6;
  constexpr double kBehind = 0.12, kThickness = 0.03;
  const double slat = kGateHeight / kSlats;
  for (int i = 0; i < kSlats; ++i)
    builder_.box(inside.relative(-kBehind - (i % 2 ? kThickness : 0), 0, 0, i * slat),
                 {kThickness, kGateWidth, slat});
  for (const int side : {-1, 1}) {  // the rails, with bollards before them
    builder_.box(inside.relative(0.05, side * (kGateWidth / 2 + 0.06)), {0.1, 0.12, kGateHeight + 0.3});
    builder_.cylinder(inside.relative(0.35, side * (kGateWidth / 2 + 0.1)), 0.08, 1.0);
  }
  builder_.box(inside.relative(0.2, 0, 0, kGateHeight), {0.4, kGateWidth + 0.4, 0.4});
  constexpr double kApron = 1.6;
  plan_.take({inside.relative(kApron / 2, 0), kApron, kGateWidth + 0.5});
}

void HallFloor::shutDoor(const Spot& inside) {
  addDoorFrame(builder_, inside, kDoorWidth, kDoorHeight);
  const Spot leaf = inside.relative(-0.1, -kDoorWidth / 2, kPi / 2);
  builder_.doorLeaf(leaf.place, leaf.yaw, kDoorWidth, kDoorHeight);
  constexpr double kWay = 0.9;
  plan_.take({inside.relative(kWay / 2, 0), kWay, kDoorWidth});
}

void HallFloor::buildWall(const Vector2d& from, const Vector2d& to, const std::vector<double>& gates,
                          const std::vector<double>& doors) {
  const double length = (to - from).norm();
  const Vector2d along = (to - from) / length;
  const double yaw = std::atan2(along.x(), -along.y());
  const auto inside = [&](double s) { return Spot{from + s * along, yaw}; };
  std::vector<Opening> openings;
  for (const double gate : gates) {
    openings.push_back({gate + kWall, kGateWidth, 0, kGateHeight});
    buildGate(inside(gate));
  }
  for (const double door : doors) {
    openings.push_back({door + kWall, kDoorWidth, 0, kDoorHeight});
    shutDoor(inside(door));
  }
  const Vector2d out = inside(0).relative(-kWall / 2, 0).place - from;
  builder_.wall(from + out - kWall * along, to + out + kWall * along, kWall, ceiling_, openings);
  addPilasters(inside(0), length);
}

void HallFloor::addPilasters(const Spot& corner, double length) {
  constexpr double kDistance = 4.0, kDepth = 0.25, kWidth = 0.35;
  const int number = static_cast<int>(length / kDistance);
  for (int i = 1; i < number; ++i) {
    const Spot spot = corner.relative(kDepth / 2, -i * length / number);
    const Footprint footprint{spot, kDepth, kWidth};
    if (!plan_.isFree(footprint)) continue;
    builder_.pillar(spot, {kDepth, kWidth, ceiling_});
    plan_.take(footprint);
  }
}

void HallFloor::buildWalls() {
  const double w = hall_.max().x(), d = hall_.max().y();
  const auto vary = [&](double s) { return s + random_.uniform(-0.4, 0.4); };
  // Racks and the store room first: no pilasters in them.
  plan_.take({Spot{{(racks_west_ + racks_east_) / 2, rack_.depth / 2}, kPi / 2}, rack_.depth + 0.2,
              rack_.length + 0.3});
  buildWall({0, 0}, {w, 0}, {}, {vary(racks_east_ + 2.2)});
  buildWall({w, 0}, {w, d}, {vary(store_.max().y() + 3.0), vary(d - 3.2)}, {});
  buildWall({w, d}, {0, d}, {vary(0.25 * w)}, {vary(0.55 * w), vary(0.85 * w)});
  buildWall({0, d}, {0, 0}, {}, {vary(0.3 * d), vary(0.75 * d)});
  const AlignedBox2d all(Vector2d(-kWall, -kWall), Vector2d(w + kWall, d + kWall));
  builder_.level(all, 0);
  builder_.level(all, ceiling_);
}

void HallFloor::buildStoreRoom() {
  const Vector2d corner(store_.min().x(), store_.max().y());
  builder_.wall({corner.x(), 0}, corner, kInnerWall, kStoreHeight,
                {{store_west_door_, kDoorWidth, 0, kDoorHeight}});
  builder_.wall(corner, store_.max(), kInnerWall, kStoreHeight,
                {{store_north_door_ - corner.x(), kDoorWidth, 0, kDoorHeight}});
  builder_.level({store_.min(), store_.max() + Vector2d(0, kInnerWall / 2)}, kStoreHeight);
  const double half = kDoorWidth / 2;
  shutLeaf({corner.x() + 0.03, store_west_door_ - half}, kPi / 2, -1);
  shutLeaf({store_north_door_ + half, corner.y() - 0.03}, kPi, 1);
  for (const double turn : {0.0, kPi}) {
    addDoorFrame(builder_, Spot{{corner.x(), store_west_door_}, turn}.relative(kInnerWall / 2, 0), kDoorWidth,
                 kDoorHeight);
    addDoorFrame(builder_, Spot{{store_north_door_, corner.y()}, turn + kPi / 2}.relative(kInnerWall / 2, 0),
                 kDoorWidth, kDoorHeight);
  }
  // Its walls, for things put up outside.
  const Vector2d middle = store_.center(), size = store_.sizes();
  plan_.take({Spot{{corner.x(), middle.y()}, 0}, kInnerWall, size.y()});
  plan_.take({Spot{{middle.x(), corner.y()}, 0}, size.x(), kInnerWall});
}

void HallFloor::shutLeaf(const Vector2d& hinge, double closed, int sense) {
  const double leaf = kDoorWidth - 0.02;
  const double later = random_.uniform(92 * kDegree, 115 * kDegree);
  builder_.doorLeaf(hinge, closed, leaf, kLeafHeight, When::mapped);
  builder_.doorLeaf(hinge, closed + sense * later, leaf, kLeafHeight, When::later);
  const Spot open{hinge, closed + sense * kPi / 2};
  constexpr double kSwing = 0.5;
  plan_.take({open.relative(kDoorWidth / 2, sense * kSwing / 2), kDoorWidth, kSwing});
}

void HallFloor::buildColumns() {
  constexpr double kSide = 0.36, kFoot = 0.5;
  const double y_round = rows_[0], y_square = rows_[1] + 0.3;
  for (double x = racks_east_ + 0.9; x < hall_.max().x() - 1.5; x += 4.4) {
    for (const bool round : {false, true}) {
      const double shift = random_.uniform(0, 0.6);
      const Spot spot{{x + shift, round ? y_round : y_square}, 0};
      const Footprint footprint{spot, kFoot, kFoot};
      if (!plan_.isFree(footprint)) continue;
      plan_.take(footprint);
      if (round) {
        builder_.roundPillar(spot, kSide / 2, ceiling_);
      } else {
        builder_.pillar(spot, {kSide, kSide, ceiling_});
      }
      if (random_.uniform() < 0.5) builder_.box(spot, {kFoot, kFoot, 0.25});
    }
  }
}

void HallFloor::buildBeams() {
  constexpr double kDistance = 4.0, kWidth = 0.3, kHeight = 0.55;
  for (double x = kDistance; x < hall_.max().x(); x += kDistance)
    builder_.box(Spot{{x, hall_.center().y()}, 0, ceiling_ - kHeight}, {kWidth, hall_.sizes().y(), kHeight});
}

}  // namespace facetloc
