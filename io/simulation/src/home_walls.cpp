// SPDX-License-Identifier: BSD-3-Clause
#include "home_floor.h"

#include <cmath>
#include <vector>

namespace facetloc {
namespace {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;

// Lengths in metres.
constexpr double kOuterWall = 0.32;  // thickness
constexpr double kDoorWidth = 1.0, kDoorHeight = 2.05, kLeafHeight = 2.03;
constexpr double kWindowTop = 2.2;

}  // namespace

void HomeFloor::dressWindow(const Spot& inside, const Opening& opening) {
  constexpr double kReach = 0.3;  // reach of things that must not hide a window
  plan_.take({inside.relative(kReach / 2, 0), kReach, opening.width},
             opening.bottom > 0 ? kHigh : kAllHeights);
  const Spot bar = inside.relative(-kOuterWall / 2, 0, 0, opening.bottom);
  builder_.box(bar, {0.06, 0.08, opening.top - opening.bottom});
  if (opening.bottom > 0) windows_.push_back(inside);
  const double curtain = random_.uniform();
  if (curtain < 0.4) return;
  constexpr double kCurtainWidth = 0.3;
  const double bottom = opening.bottom > 0 ? opening.bottom - 0.1 : 0.03;
  for (const int side : {-1, 1})
    addCurtain(builder_, inside.relative(0, side * opening.width / 2, 0, bottom), kCurtainWidth,
               kWindowTop + 0.1 - bottom, random_);
}

Opening HomeFloor::drawWindow(double at) {
  const double width = random_.uniform(1.1, 1.7);
  const double bottom = random_.uniform(0.8, 0.95);
  return {at, width, bottom, kWindowTop, true};
}

void HomeFloor::buildOuterWalls() {
  const double out = kOuterWall / 2;
  const double right = width_ + out, top = depth_ + out;
  const auto wall = [&](const Vector2d& from, const Vector2d& to, const std::vector<Opening>& openings) {
    // Outside to the right of the way from its start to its end.
    const Vector2d along = (to - from).normalized();
    const double yaw = std::atan2(along.x(), -along.y());
    for (const Opening& opening : openings) {
      if (!opening.glazed) continue;
      dressWindow(Spot{from + opening.at * along, yaw}.relative(out, 0), opening);
    }
    builder_.wall(from, to, kOuterWall, kCeiling, openings);
  };
  Opening balcony = drawWindow(out + 0.42 * west_);
  balcony.bottom = 0;
  const double bedroom = 0.56 * bedroom_a_.sizes().x();
  Opening window_a = drawWindow(out + bedroom_a_.min().x() + bedroom);
  Opening window_b = window_a;
  window_b.at += bedroom_b_.min().x() - bedroom_a_.min().x();
  wall({-out, -out}, {right, -out}, {balcony, window_a, window_b});
  constexpr double kEntranceWidth = 0.95;
  const Opening entrance{out + (south_ + north_) / 2, kEntranceWidth};
  wall({right, -out}, {right, top}, {entrance});
  builder_.doorLeaf({width_ + 0.05, (south_ + north_ - kEntranceWidth) / 2}, kPi / 2, kEntranceWidth,
                    kDoorHeight);
  Opening bath_window = drawWindow(right - bath_room_.center().x());
  bath_window.width = 0.7;
  bath_window.bottom = 1.3;
  const Opening study_window = drawWindow(right - study_.center().x());
  wall({right, top}, {-out, top}, {bath_window, study_window});
  const Opening kitchen_window = drawWindow(top - kitchen_room_.center().y());
  const Opening living_window = drawWindow(top - 0.55 * living_room_.sizes().y());
  wall({-out, top}, {-out, -out}, {kitchen_window, living_window});
  const AlignedBox2d all(Vector2d(-out, -out), Vector2d(right, top));
  builder_.level(all, 0);
  builder_.level(all, kCeiling);
}

void HomeFloor::buildInnerWalls() {
  const auto door = [](double at) { return Opening{at, kDoorWidth, 0, kDoorHeight}; };
  const double middle = (south_ + north_) / 2;
  builder_.wall({west_, 0}, {west_, depth_}, kWall, kCeiling,
                {{middle, kHallwayWidth - 0.5, 0, 2.15}, door(pantry_door_)});
  constexpr double kPassage = 1.7;
  builder_.wall({0, kitchen_}, {west_, kitchen_}, kWall, kCeiling, {{kitchen_opening_, kPassage, 0, 2.2}});
  builder_.wall({west_, south_}, {width_, south_}, kWall, kCeiling,
                {door(door_a_ - west_), door(door_b_ - west_)});
  builder_.wall({west_, north_}, {width_, north_}, kWall, kCeiling,
                {door(study_door_ - west_), door(door_b_ - west_)});
  builder_.wall({between_bedrooms_, 0}, {between_bedrooms_, south_}, kWall, kCeiling);
  builder_.wall({bath_, north_}, {bath_, depth_}, kWall, kCeiling);
}

void HomeFloor::openLeaf(const Vector2d& hinge, double closed, int sense, double most) {
  constexpr double kLeast = 89 * kDegree;
  const double leaf = kDoorWidth - 0.02;
  const double mapped = random_.uniform(kLeast, most), later = random_.uniform(kLeast, most);
  if (random_.uniform() < 0.4) {
    builder_.doorLeaf(hinge, closed + sense * mapped, leaf, kLeafHeight);
  } else {
    builder_.doorLeaf(hinge, closed + sense * mapped, leaf, kLeafHeight, When::mapped);
    builder_.doorLeaf(hinge, closed + sense * later, leaf, kLeafHeight, When::later);
  }
  takeLeaf(hinge, closed, sense);
}

void HomeFloor::shutLeaf(const Vector2d& hinge, double closed, int sense) {
  const double leaf = kDoorWidth - 0.02;
  const double later = random_.uniform(91 * kDegree, 105 * kDegree);
  builder_.doorLeaf(hinge, closed, leaf, kLeafHeight, When::mapped);
  builder_.doorLeaf(hinge, closed + sense * later, leaf, kLeafHeight, When::later);
  takeLeaf(hinge, closed, sense);
}

void HomeFloor::takeLeaf(const Vector2d& hinge, double closed, int sense) {
  const Spot open{hinge, closed + sense * kPi / 2};
  constexpr double kSwing = 0.4;
  plan_.take({open.relative(kDoorWidth / 2, sense * kSwing / 2), kDoorWidth, kSwing});
}

void HomeFloor::buildDoors() {
  const double half = kDoorWidth / 2, face = kWall / 2;
  constexpr double kUpToWall = 100 * kDegree, kWide = 125 * kDegree;
  openLeaf({door_a_ - half, south_ - face}, 0, -1, kUpToWall);
  openLeaf({door_b_ - half, south_ - face}, 0, -1, kUpToWall);
  openLeaf({door_b_ + half, north_ + face}, kPi, -1, kWide);
  shutLeaf({study_door_ + half, north_ + 0.03}, kPi, -1);
  shutLeaf({west_ + 0.03, pantry_door_ + half}, -kPi / 2, 1);
  addFrames();
  // Nothing on the walls at the openings.
  const auto keep = [&](double x, double y, double depth, double width) {
    plan_.take({Spot{{x, y}, 0}, depth, width});
  };
  keep(west_, pantry_door_, 0.5, kDoorWidth);
  keep(west_, (south_ + north_) / 2, 0.5, kHallwayWidth - 0.5);
  keep(kitchen_opening_, kitchen_, 1.7, 0.5);
  for (const double x : {door_a_, door_b_}) keep(x, south_, kDoorWidth, 0.5);
  for (const double x : {study_door_, door_b_}) keep(x, north_, kDoorWidth, 0.5);
  keep(width_, (south_ + north_) / 2, 0.3, kDoorWidth);
}

void HomeFloor::addFrames() {
  const double face = kWall / 2;
  const auto frames = [&](const Vector2d& door, double yaw) {
    for (const double turn : {0.0, kPi})
      addDoorFrame(builder_, Spot{door, yaw + turn}.relative(face, 0), kDoorWidth, kDoorHeight);
  };
  frames({door_a_, south_}, kPi / 2);
  frames({door_b_, south_}, kPi / 2);
  frames({door_b_, north_}, kPi / 2);
  frames({study_door_, north_}, kPi / 2);
  frames({west_, pantry_door_}, 0);
}

void HomeFloor::addShaft(const Vector2d& corner, const Vector2d& inward) {
  const double x = random_.uniform(0.35, 0.6), y = random_.uniform(0.3, 0.5);
  const Spot spot{corner + Vector2d(inward.x() * x / 2, inward.y() * y / 2), 0};
  builder_.pillar(spot, {x, y, kCeiling});
  plan_.take({spot, x, y});
}

}  // namespace facetloc
