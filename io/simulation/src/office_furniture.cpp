// SPDX-License-Identifier: BSD-3-Clause
#include "furniture.h"
#include "office_floor.h"

#include <algorithm>

namespace facetloc {
namespace {

constexpr double kShareMoved = 0.2;  // share of the loose things

}  // namespace

void OfficeFloor::furnishWall(const Side& side) {
  const double free = corridor_ / 2 - kLane;  // depth that things may have
  for (double s = 0.3 + spacing_; s < side.length() - 0.6; s += spacing_) {
    if (isRoomDoor(side, s, 1.3)) continue;
    const Spot spot{side.at(s), side.yaw()};
    const double choice = random_.uniform();
    if (choice < 0.25) {
      pillar(spot, std::min(free, random_.uniform(0.12, 0.3)));
    } else if (choice < 0.45) {
      const double depth = std::min(free, 0.38);
      const double width = random_.uniform(0.7, 1.1), height = random_.uniform(0.8, 2.0);
      const bool dark = random_.uniform() < 0.2;
      movable(spot, random_.uniform(-0.3, 0.3), [&](const Spot& at, When when) {
        builder_.box(at.relative(depth / 2 + 0.01, 0), {depth, width, height}, when,
                     dark ? Material::dark : Material::matt);
      });
    } else if (choice < 0.65) {
      noticeBoard(spot);
    } else if (choice < 0.8) {
      furniture(spot.relative(0.24, 0), addBin);
    } else if (choice < 0.88 && free > 0.4) {
      furniture(spot.relative(0.26, 0), addPlant);
    }
  }
}

void OfficeFloor::pillar(const Spot& spot, double depth) {
  builder_.pillar(spot.relative(depth / 2, 0), {depth, random_.uniform(0.3, 0.5), kCeiling});
}

void OfficeFloor::noticeBoard(const Spot& spot) {
  const double width = random_.uniform(0.6, 1.4), height = random_.uniform(0.6, 1.0);
  builder_.box(spot.relative(0.02, 0, 0, random_.uniform(1.0, 1.3)), {0.04, width, height});
}

template <class Add>
void OfficeFloor::movable(const Spot& spot, double shift, const Add& add) {
  const double fate = random_.uniform();
  if (fate > kShareMoved) return add(spot, When::always);
  add(spot, When::mapped);
  if (fate > kShareMoved / 3) add(spot.relative(0, shift), When::later);
}

template <class Add>
void OfficeFloor::furniture(const Spot& spot, const Add& add) {
  constexpr std::uint64_t kPurpose = 1;
  const Random sizes(derivedSeed(seed_, kPurpose, ++pieces_));
  movable(spot, random_.uniform(-0.3, 0.3), [&](const Spot& at, When when) {
    Random same = sizes;
    add(builder_, at, same, when);
  });
}

void OfficeFloor::furnishRoom(const Spot& door, const Room& room) {
  const double turn = random_.uniform() < 0.5 ? 1 : -1;  // which side is called the left
  const double left = (turn > 0 ? room.left : room.right) - kWall / 2;
  const double right = (turn > 0 ? room.right : room.left) - kWall / 2;
  const double depth = room.depth - kWall / 2;
  const auto at = [&](double x, double y, double yaw, double z = 0) {
    return door.relative(x, turn * y, turn * yaw, z);
  };
  const auto likely = [&](double probability) { return random_.uniform() < probability; };

  const double desk = depth - random_.uniform(0.9, 1.5);
  furniture(at(desk, left - 0.4, -kQuarter), addDesk);
  furniture(at(desk + random_.uniform(-0.2, 0.2), left - 1.0, kQuarter), addChair);
  if (likely(0.6)) furniture(at(depth - random_.uniform(0.9, 1.4), -(right - 0.4), kQuarter), addDesk);
  if (likely(0.6)) furniture(at(random_.uniform(0.9, 1.3), -(right - 0.2), kQuarter), addBookcase);
  if (likely(0.6)) furniture(at(random_.uniform(1.2, 1.6), left - 0.25, -kQuarter), addCupboard);
  if (likely(0.5)) furniture(at(depth - 0.4, random_.uniform(-0.4, 0.4), 2 * kQuarter), addPlant);
  if (likely(0.35)) furniture(at(depth - 0.7, -(right - 1.0), random_.uniform(-3, 3)), addPerson);
  for (const Opening& window : room.windows)
    builder_.box(door.relative(depth - 0.06, room.left - window.at, 0, 0.15),
                 {0.1, 0.75 * window.width, 0.6});

  // Boards on the walls at the sides, and beside the door.
  const auto board = [&](const Spot& spot, double width) {
    builder_.box(spot, {0.04, width, random_.uniform(0.5, 1.0)});
  };
  if (likely(0.8))
    board(at(random_.uniform(1.6, 2.6), left - 0.02, -kQuarter, 1.15), random_.uniform(0.6, 1.6));
  if (likely(0.7))
    board(at(random_.uniform(1.6, 2.8), -(right - 0.02), kQuarter, 1.2), random_.uniform(0.4, 1.4));
  if (likely(0.5)) board(at(0.02, -(0.75 + right) / 2, 0, random_.uniform(0.9, 1.3)), 0.6 * (right - 0.7));
}

}  // namespace facetloc
