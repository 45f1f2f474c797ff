// SPDX-License-Identifier: BSD-3-Clause
// Things of all rooms: desks, tables and chairs, cupboards and bookcases, small things, people, and fittings.
#include "furniture_parts.h"

#include <facetloc/features/pose.h>

#include <cmath>
#include <vector>

namespace facetloc {

void addDesk(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const auto [depth, width, height, middle] = drawn(kind::kDesk, spot, 0.68, 1.2, 0.70, 0.76, random);
  builder.box(middle.relative(0, 0, 0, height - 0.03), {depth, width, 0.03}, when);
  if (chance(random, 0.5)) {
    legs(builder, middle, depth, width, height - 0.03, 0.05, when);
    builder.box(middle.relative(-depth / 2 + 0.02, 0, 0, 0.3), {0.02, width - 0.12, 0.36}, when);
  } else {
    for (const int side : {-1, 1})
      builder.box(middle.relative(0, side * (width / 2 - 0.02)), {depth - 0.04, 0.03, height - 0.03}, when);
  }
  const int side = chance(random, 0.5) ? 1 : -1;
  const double chest = random.uniform(0.5, 0.6);
  builder.box(middle.relative(0, side * (width / 2 - 0.28)), {0.55, 0.42, chest}, when);
  const double screen_y = random.uniform(-0.25, 0.25);
  const double turn = random.uniform(-25, 25) * kDegree;
  const double screen_width = random.uniform(0.45, 0.62);
  addScreen(builder, middle.relative(-0.14, screen_y, turn, height), screen_width, random, when);
  const double stack = random.uniform(0.03, 0.2);
  const double stack_turn = random.uniform(-30, 30) * kDegree;
  builder.box(middle.relative(0.08, -side * (width / 2 - 0.25), stack_turn, height), {0.3, 0.22, stack},
              when);
}

void addChair(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const double side = random.uniform(0.41, 0.47);
  const double seat = random.uniform(0.42, 0.48);
  const double back = random.uniform(0.38, 0.5);
  const double lean = -random.uniform(6, 16);
  const bool swivels = chance(random, 0.5);
  const double thickness = swivels ? 0.08 : 0.035;
  builder.box(spot.relative(0, 0, 0, seat - thickness), {side, side, thickness}, when);
  if (swivels) {
    builder.cylinder(spot.relative(0, 0, 0, 0.1), 0.03, seat - thickness - 0.1, when, Material::dark);
    constexpr int kFeet = 5;
    for (int i = 0; i < kFeet; ++i)
      builder.box(spot.relative(0, 0, i * 360 * kDegree / kFeet, 0.06).relative(0.15, 0), {0.26, 0.04, 0.04},
                  when, Material::dark);
  } else {
    legs(builder, spot, side, side, seat - thickness, 0.035, when);
  }
  const double back_width = swivels ? side - 0.04 : side;
  const double gap = swivels ? 0.12 : 0.06;
  const double back_x = -side / 2 + 0.01 + std::sin(lean * kDegree) * (gap + back / 2);
  slab(builder, spot.relative(back_x, 0), seat + gap + back / 2, lean,
       {swivels ? 0.06 : 0.025, back_width, back}, when);
  if (swivels)
    slab(builder, spot.relative(-side / 2, 0), seat + 0.04, lean, {0.02, 0.08, 0.26}, when, Material::dark);
}

void addTable(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const double depth = random.uniform(0.75, kind::kTable.depth);
  const double width = random.uniform(1.2, kind::kTable.width);
  const double height = random.uniform(0.71, 0.77);
  builder.box(spot.relative(0, 0, 0, height - 0.03), {depth, width, 0.03}, when);
  builder.box(spot.relative(0, 0, 0, height - 0.11), {depth - 0.16, width - 0.16, 0.08}, when);
  legs(builder, spot, depth - 0.06, width - 0.06, height - 0.03, 0.07, when);
  const int things = count(random, 0, 3);
  addOddments(builder, spot.relative(0, 0, 0, height), depth, width, things, random, when);
}

void addRoundTable(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const double radius = random.uniform(0.42, kind::kRoundTable.width / 2);
  const double height = random.uniform(0.71, 0.76);
  builder.cylinder(spot.relative(0, 0, 0, height - 0.03), radius, 0.03, when);
  builder.cylinder(spot, 0.05, height - 0.03, when);
  builder.cylinder(spot, 0.25, 0.03, when);
  addOddments(builder, spot.relative(0, 0, 0, height), radius, radius, count(random, 0, 2), random, when);
}

void addCoffeeTable(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const double depth = random.uniform(0.5, kind::kCoffeeTable.depth);
  const double width = random.uniform(0.7, kind::kCoffeeTable.width);
  const double height = random.uniform(0.38, 0.5);
  const bool glass = chance(random, 0.2);
  builder.box(spot.relative(0, 0, 0, height - 0.025), {depth, width, 0.025}, when,
              glass ? Material::glass : Material::matt);
  legs(builder, spot, depth, width, height - 0.025, 0.05, when);
  if (chance(random, 0.6)) builder.box(spot.relative(0, 0, 0, 0.14), {depth - 0.1, width - 0.1, 0.02}, when);
  addOddments(builder, spot.relative(0, 0, 0, height), depth, width, count(random, 0, 2), random, when);
}

void addCupboard(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const double depth = random.uniform(0.36, kind::kCupboard.depth);
  const double width = random.uniform(0.7, kind::kCupboard.width);
  const bool tall = chance(random, 0.5);
  const double height = tall ? random.uniform(1.5, 2.0) : random.uniform(0.75, 1.25);
  const bool dark = chance(random, kDarkCupboards);
  const Spot middle = spot.relative((depth - kind::kCupboard.depth) / 2, 0);
  addCarcass(builder, middle, depth, width, height, 2, when, darkIf(dark));
  const int things = count(random, 0, 3);
  addOddments(builder, middle.relative(0, 0, 0, height), depth, width, things, random, when);
}

void addSideboard(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const auto [depth, width, height, middle] = drawn(kind::kSideboard, spot, 0.38, 1.2, 0.7, 0.95, random);
  const bool dark = chance(random, kDarkCupboards);
  addCarcass(builder, middle, depth, width, height, 3, when, darkIf(dark));
  addOddments(builder, middle.relative(0, 0, 0, height), depth, width, count(random, 1, 4), random, when);
}

void addWardrobe(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const auto [depth, width, height, middle] = drawn(kind::kWardrobe, spot, 0.55, 1.0, 1.9, 2.2, random);
  const bool dark = chance(random, kDarkCupboards);
  addCarcass(builder, middle, depth, width, height, width > 1.3 ? 3 : 2, when, darkIf(dark));
}

void addShoeCupboard(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const auto [depth, width, height, middle] = drawn(kind::kShoeCupboard, spot, 0.22, 0.6, 0.75, 1.2, random);
  addCarcass(builder, middle, depth, width, height, 1, when, Material::matt);
  if (chance(random, 0.6)) builder.box(middle.relative(0, 0.1, 0.3, height), {0.16, 0.2, 0.1}, when);
}

void addBookcase(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const auto [depth, width, height, middle] = drawn(kind::kBookcase, spot, 0.27, 0.6, 1.2, 2.1, random);
  const double distance = random.uniform(0.3, 0.4);
  const std::vector<double> tops = addOpenShelf(builder, middle, depth, width, height, distance, when);
  for (std::size_t i = 0; i + 1 < tops.size(); ++i)
    addBooks(builder, middle.relative(0.005, 0, 0, tops[i]), depth - 0.02, width - 2 * kBoard,
             tops[i + 1] - tops[i] - kBoard, random, when);
}

void addLamp(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const double height = random.uniform(1.35, 1.65);
  const double shade = random.uniform(0.14, kind::kLamp.width / 2);
  builder.cylinder(spot, 0.14, 0.025, when);
  builder.cylinder(spot, 0.015, height, when, Material::dark);
  builder.cylinder(spot.relative(0, 0, 0, height - 0.15), shade, 0.3, when);
}

void addBin(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const double height = random.uniform(0.28, 0.62);
  const double width = random.uniform(0.22, kind::kBin.width);
  if (chance(random, 0.5)) {
    builder.cylinder(spot, width / 2, height, when);
  } else {
    const double depth = random.uniform(0.2, width);
    builder.box(spot, {depth, width, height}, when);
  }
}

void addPlant(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const double pot = random.uniform(0.12, 0.19);
  const double pot_height = random.uniform(0.22, 0.4);
  const double height = random.uniform(0.8, 1.7);
  const double crown = random.uniform(0.18, 0.27);
  builder.cylinder(spot, pot, pot_height, when);
  builder.cylinder(spot.relative(0.01, 0.02, 0, pot_height), 0.015, 0.7 * (height - pot_height), when);
  const int leaves = count(random, 10, 18);
  for (int i = 0; i < leaves; ++i) {
    const double direction = random.uniform(0, 360) * kDegree;
    const double out = crown * std::sqrt(random.uniform());
    const double z = random.uniform(pot_height + 0.12, height);
    const double length = random.uniform(0.06, 0.13);
    const double thickness = random.uniform(0.01, 0.05);
    builder.ellipsoid(spot.relative(0, 0, direction).relative(out, 0), z,
                      {length, 0.5 * length + 0.01, thickness}, when);
  }
}

void addPerson(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const double height = random.uniform(1.58, 1.88);
  const double stout = random.uniform(0.85, 1.2);
  const double stride = random.uniform(0, 0.12);
  const Material trousers = darkIf(chance(random, kDarkClothes));
  const Material jacket = darkIf(chance(random, kDarkClothes));
  for (const int side : {-1, 1}) {
    builder.ellipsoid(spot.relative(side * stride, side * 0.1), 0.25 * height,
                      {0.08 * stout, 0.08 * stout, 0.27 * height}, when, trousers);
    builder.ellipsoid(spot.relative(side * stride + 0.05, side * 0.1), 0.04, {0.13, 0.05, 0.05}, when);
    builder.ellipsoid(spot.relative(-side * stride / 2, side * 0.21 * stout), 0.63 * height,
                      {0.05, 0.05, 0.17 * height}, when, jacket);
  }
  builder.ellipsoid(spot, 0.65 * height, {0.13 * stout, 0.2 * stout, 0.19 * height}, when, jacket);
  builder.cylinder(spot.relative(0, 0, 0, 0.8 * height), 0.055, 0.06 * height, when);
  builder.ellipsoid(spot, 0.93 * height, {0.1, 0.08, 0.07 * height}, when);
}

void addRadiator(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const double width = random.uniform(0.7, kind::kRadiator.width);
  const double height = random.uniform(0.5, 0.75);
  const double depth = random.uniform(0.06, 0.11);
  constexpr double kFoot = 0.12;
  builder.box(spot.relative((kind::kRadiator.depth - depth) / 2, 0, 0, kFoot), {depth, width, height}, when);
  builder.cylinder(spot.relative(0.02, width / 2 + 0.03, 0, kFoot), 0.025, 0.12, when);
}

void addCoats(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const double back = -kind::kCoats.depth / 2, width = kind::kCoats.width;
  const double hooks = random.uniform(1.6, 1.75);
  builder.box(spot.relative(back + 0.1, 0, 0, hooks), {0.2, width, 0.03}, when);
  const int coats = count(random, 1, 4);
  for (int i = 0; i < coats; ++i) {
    const double y = ((i + 0.5) / coats - 0.5) * width + random.uniform(-0.04, 0.04);
    const double half_length = random.uniform(0.3, 0.5);
    const double half_depth = random.uniform(0.06, 0.13);
    builder.ellipsoid(spot.relative(back + half_depth, y), hooks - half_length,
                      {half_depth, 0.14, half_length}, when, darkIf(chance(random, kDarkClothes)));
  }
}

void addCarton(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const double depth = random.uniform(0.25, 0.45), width = random.uniform(0.25, 0.5);
  const double height = random.uniform(0.2, 0.45);
  builder.box(spot, {depth, width, height}, when);
  if (chance(random, 0.4))
    builder.box(spot.relative(0, 0, 0.2, height), {0.7 * depth, 0.7 * width, 0.7 * height}, when);
}

void addPicture(SceneBuilder& builder, const Spot& on_wall, double width, double height) {
  constexpr double kFrame = 0.03;
  builder.box(on_wall.relative(kFrame / 2, 0), {kFrame, width, height});
}

void addDoorFrame(SceneBuilder& builder, const Spot& on_wall, double width, double height) {
  constexpr double kThickness = 0.02, kWidth = 0.08;
  for (const int side : {-1, 1})
    builder.box(on_wall.relative(kThickness / 2, side * (width + kWidth) / 2), {kThickness, kWidth, height});
  builder.box(on_wall.relative(kThickness / 2, 0, 0, height), {kThickness, width + 2 * kWidth, kWidth});
}

void addWallShelf(SceneBuilder& builder, const Spot& on_wall, double width, Random& random) {
  constexpr double kDepth = 0.24;
  const Spot board = on_wall.relative(kDepth / 2, 0);
  builder.box(board, {kDepth, width, 0.03});
  addBooks(builder, board.relative(0, 0, 0, 0.03), kDepth, width, 0.32, random, When::always);
}

void addCurtain(SceneBuilder& builder, const Spot& on_wall, double width, double height, Random& random,
                When when) {
  double y = -width / 2;
  while (true) {
    const double radius = random.uniform(0.03, 0.06);
    const double out = random.uniform(0.06, 0.09);
    if (y + 1.7 * radius > width / 2) return;
    builder.cylinder(on_wall.relative(out, y + 0.85 * radius), radius, height, when);
    y += 1.7 * radius;  // folds overlap a little
  }
}

void addPendantLamp(SceneBuilder& builder, const Spot& on_floor, double ceiling, Random& random) {
  const double length = random.uniform(0.5, 0.8), radius = random.uniform(0.15, 0.28);
  builder.cylinder(on_floor.relative(0, 0, 0, ceiling - length), 0.006, length, When::always, Material::dark);
  builder.ellipsoid(on_floor, ceiling - length, {radius, radius, 0.6 * radius});
}

}  // namespace facetloc
