// SPDX-License-Identifier: BSD-3-Clause
// Kitchens and bathrooms.
#include "furniture.h"
#include "furniture_parts.h"

namespace facetloc {

void addKitchenUnit(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const double width = kind::kKitchenUnit.width, depth = kind::kKitchenUnit.depth;
  constexpr double kWorktop = 0.9, kTop = 0.04, kPlinth = 0.1, kJut = 0.03, kOven = 0.6;
  const double body = depth - kJut;
  const Spot middle = spot.relative(-kJut / 2, 0);
  builder.box(middle.relative(-0.04, 0), {body - 0.08, width, kPlinth}, when, Material::dark);
  builder.box(middle.relative(0, 0, 0, kPlinth), {body, width, kWorktop - kTop - kPlinth}, when);
  builder.box(spot.relative(0, 0, 0, kWorktop - kTop), {depth, width, kTop}, when);
  const double front = depth / 2 - kJut;
  for (int i = 0; i < 4; ++i)
    builder.box(spot.relative(front + 0.012, (i - 1.5) * width / 4, 0, 0.78), {0.024, 0.3, 0.015}, when);
  const int side = chance(random, 0.5) ? 1 : -1;
  const double oven = side * (width / 2 - kOven);
  builder.box(spot.relative(front + 0.008, oven, 0, 0.2), {0.016, kOven - 0.04, 0.5}, when, Material::dark);
  builder.box(spot.relative(0, oven, 0, kWorktop), {0.5, 0.56, 0.008}, when, Material::dark);
  // A hood above the hob, wall cupboards beside it.
  const double shelf_depth = random.uniform(0.32, 0.37);
  const double bottom = random.uniform(1.38, 1.5);
  const double top = random.uniform(2.05, 2.2);
  const double shelf_x = -depth / 2 + shelf_depth / 2;
  slab(builder, spot.relative(-depth / 2 + 0.24, oven), 1.62, -random.uniform(35, 55), {0.02, kOven, 0.46},
       when);
  builder.box(spot.relative(-depth / 2 + 0.14, oven, 0, 1.75), {0.28, 0.3, top - 1.75}, when);
  const double free = width - 1.5 * kOven;
  builder.box(spot.relative(shelf_x, side * (free / 2 - width / 2), 0, bottom),
              {shelf_depth, free, top - bottom}, when);
  // A tap, and things on the worktop.
  const double tap = side * random.uniform(-0.8, -0.4);
  builder.cylinder(spot.relative(-depth / 2 + 0.1, tap, 0, kWorktop), 0.018, 0.28, when);
  const double oven_width = random.uniform(0.42, 0.5);
  builder.box(spot.relative(-0.08, oven - side * 0.65, 0.05, kWorktop), {0.34, oven_width, 0.27}, when,
              darkIf(chance(random, 0.5)));
  addOddments(builder, spot.relative(-0.05, -side * width / 4, 0, kWorktop), 0.45, width / 2,
              count(random, 1, 3), random, when);
}

void addFridge(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const double height = random.uniform(1.45, 1.95);
  const double freezer = random.uniform(0.5, 0.75);
  constexpr double kDoor = 0.05;
  const double body = kind::kFridge.depth - 0.06;
  builder.box(spot.relative(-0.03, 0), {body, kind::kFridge.width, height}, when);
  const double front = body / 2 - 0.03 + kDoor / 2;
  builder.box(spot.relative(front, 0, 0, 0.05), {kDoor, kind::kFridge.width - 0.02, freezer - 0.06}, when);
  builder.box(spot.relative(front, 0, 0, freezer),
              {kDoor, kind::kFridge.width - 0.02, height - freezer - 0.01}, when);
  if (chance(random, 0.5)) builder.box(spot.relative(0, 0, 0.1, height), {0.3, 0.4, 0.2}, when);
}

void addBathtub(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  constexpr double kRim = 0.07, kGround = 0.14;
  const double height = random.uniform(0.52, 0.6);
  const double depth = kind::kBathtub.depth, width = kind::kBathtub.width;
  builder.box(spot, {depth - 2 * kRim, width - 2 * kRim, kGround}, when);
  for (const int side : {-1, 1}) {
    builder.box(spot.relative(side * (depth - kRim) / 2, 0), {kRim, width, height}, when);
    builder.box(spot.relative(0, side * (width - kRim) / 2), {depth - 2 * kRim, kRim, height}, when);
  }
  builder.cylinder(spot.relative(-depth / 2 + 0.08, 0, 0, height), 0.025, 0.2, when);
  if (chance(random, 0.5))  // a screen against splashes
    builder.box(spot.relative(depth / 2 - 0.04, width / 4, 0, height), {0.01, width / 2, 1.3}, when,
                Material::glass);
}

void addToilet(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const double back = -kind::kToilet.depth / 2;
  const double tank = random.uniform(0.75, 0.9);
  builder.box(spot.relative(back + 0.09, 0, 0, 0.4), {0.18, 0.38, tank - 0.4}, when);
  builder.box(spot.relative(back + 0.2, 0), {0.36, 0.2, 0.36}, when);
  builder.ellipsoid(spot.relative(back + 0.42, 0), 0.26, {0.24, 0.18, 0.15}, when);
  builder.cylinder(spot.relative(back + 0.44, 0, 0, 0.36), 0.19, 0.05, when);
}

void addWashbasin(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const double depth = random.uniform(0.42, kind::kWashbasin.depth);
  const double width = random.uniform(0.5, kind::kWashbasin.width);
  const double height = random.uniform(0.82, 0.88);
  const double back = -kind::kWashbasin.depth / 2;
  const Spot middle = spot.relative(back + depth / 2, 0);
  builder.box(middle.relative(0, 0, 0, height - 0.14), {depth, width, 0.14}, when);
  if (chance(random, 0.5)) {
    builder.cylinder(middle.relative(-0.05, 0), 0.09, height - 0.14, when);
  } else {
    builder.box(middle.relative(-0.03, 0, 0, 0.2), {depth - 0.08, width - 0.06, height - 0.34}, when);
  }
  builder.cylinder(spot.relative(back + 0.07, 0, 0, height), 0.02, 0.14, when);
  // A cabinet with a mirror above it: mirrors answer a depth camera in patches, like glass.
  const double mirror = random.uniform(0.5, 0.8);
  builder.box(spot.relative(back + 0.07, 0, 0, 1.25), {0.14, width, mirror}, when);
  builder.box(spot.relative(back + 0.145, 0, 0, 1.26), {0.01, width - 0.04, mirror - 0.02}, when,
              Material::glass);
}

void addWashingMachine(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const double depth = random.uniform(0.52, kind::kWashingMachine.depth - 0.02);
  const double back = -kind::kWashingMachine.depth / 2;
  builder.box(spot.relative(back + depth / 2, 0), {depth, kind::kWashingMachine.width, 0.85}, when);
  builder.ellipsoid(spot.relative(back + depth, 0), 0.45, {0.02, 0.17, 0.17}, when, Material::dark);
  addOddments(builder, spot.relative(back + depth / 2, 0, 0, 0.85), depth, kind::kWashingMachine.width,
              count(random, 0, 2), random, when);
}

}  // namespace facetloc
