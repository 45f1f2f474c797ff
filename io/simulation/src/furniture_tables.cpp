// SPDX-License-Identifier: BSD-3-Clause
// Desks, tables and the chairs at them.
#include "furniture.h"
#include "furniture_parts.h"

#include <facetloc/features/pose.h>

#include <cmath>

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

}  // namespace facetloc
