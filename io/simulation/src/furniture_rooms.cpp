// SPDX-License-Identifier: BSD-3-Clause
// Things of offices and homes: furniture, small things, people, and fittings.
#include "furniture_parts.h"

#include <facetloc/features/pose.h>

#include <cmath>
#include <vector>

namespace facetloc {
namespace {

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

// ---- Living rooms and bedrooms ----

/** A sofa or an armchair: arms, a back that leans, seat cushions. */
void addSeat(const Kind& kind, double least_depth, double least_width, SceneBuilder& builder, const Spot& at,
             Random& random, When when) {
  const double depth = random.uniform(least_depth, kind.depth);
  const double width = random.uniform(least_width, kind.width);
  const Spot spot = at.relative((depth - kind.depth) / 2, 0);
  const int cushions = width > 1.85 ? 3 : width > 1.0 ? 2 : 1;
  const double arm = random.uniform(0.12, 0.2);
  const double arm_height = random.uniform(0.5, 0.65);
  const double seat = random.uniform(0.38, 0.45);
  const double back = random.uniform(0.72, 0.95);
  const double lean = -random.uniform(4, 14);
  const Material material = darkIf(chance(random, kDarkSofas));
  constexpr double kCushion = 0.14, kBack = 0.2, kFoot = 0.06;
  const double inner = width - 2 * arm;
  builder.box(spot.relative(0, 0, 0, kFoot), {depth - 0.04, inner, seat - kCushion - kFoot}, when, material);
  for (const int side : {-1, 1})
    builder.box(spot.relative(0, side * (width - arm) / 2), {depth, arm, arm_height}, when, material);
  for (int i = 0; i < cushions; ++i) {
    const double y = ((i + 0.5) / cushions - 0.5) * inner;
    const double out = random.uniform(0, 0.03);
    builder.box(spot.relative(kBack / 2 - 0.02 + out, y, 0, seat - kCushion),
                {depth - kBack, inner / cushions - 0.015, kCushion}, when, material);
  }
  builder.box(spot.relative(-depth / 2 + 0.03, 0), {0.06, inner, back - 0.12}, when, material);
  slab(builder, spot.relative(-depth / 2 + kBack / 2 + 0.06, 0), (seat + back) / 2 - 0.04, lean,
       {kBack - 0.04, inner, back - seat + 0.06}, when, material);
  const int pillows = count(random, 0, cushions);
  for (int i = 0; i < pillows; ++i) {
    const double y = random.uniform(-0.4, 0.4) * inner;
    const double turn = random.uniform(-30, 30) * kDegree;
    builder.ellipsoid(spot.relative(-0.1, y, turn), seat + 0.18, {0.09, 0.2, 0.19}, when);
  }
}

void addSofa(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  addSeat(kind::kSofa, 0.82, 1.6, builder, spot, random, when);
}

void addArmchair(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  addSeat(kind::kArmchair, 0.75, 0.75, builder, spot, random, when);
}

void addTvStand(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const auto [depth, width, height, middle] = drawn(kind::kTvStand, spot, 0.36, 1.2, 0.4, 0.6, random);
  addCarcass(builder, middle, depth, width, height, 2, when, Material::matt);
  const double screen = random.uniform(0.9, 1.2);
  const double turn = random.uniform(-8, 8) * kDegree;
  const double y = random.uniform(-0.1, 0.1);
  const Spot top = middle.relative(-0.02, y, turn, height);
  builder.box(top, {0.2, 0.4, 0.02}, when, Material::dark);
  slab(builder, top, 0.06 + 0.29 * screen, -2, {0.05, screen, 0.58 * screen}, when, Material::dark);
  if (chance(random, 0.7))
    builder.cylinder(middle.relative(0, width / 2 - 0.12, 0, height), 0.06, random.uniform(0.12, 0.3), when);
}

/** Pillows, a blanket thrown back or spread, and perhaps somebody under it. */
void addBedding(SceneBuilder& builder, const Spot& top, double length, double width, Random& random,
                When when) {
  const int pillows = width > 1.3 ? 2 : 1;
  for (int i = 0; i < pillows; ++i) {
    const double y = (pillows == 1 ? 0 : (i - 0.5) * width * 0.48) + random.uniform(-0.06, 0.06);
    const double turn = random.uniform(-15, 15) * kDegree;
    builder.ellipsoid(top.relative(-length / 2 + 0.32, y, turn), 0.06, {0.22, 0.32, 0.09}, when);
  }
  const double cover = random.uniform(0.5, 1.3);
  const double turn = random.uniform(-4, 4) * kDegree;
  builder.box(top.relative(length / 2 - 0.1 - cover / 2, 0, turn), {cover, width - 0.2, 0.05}, when);
  if (chance(random, 0.5)) builder.ellipsoid(top.relative(0.1, 0.05), 0.04, {0.3, 0.3 * width, 0.14}, when);
}

void addBed(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const double width =
      chance(random, 0.5) ? random.uniform(0.95, 1.1) : random.uniform(1.45, kind::kBed.width);
  const double length = random.uniform(2.02, kind::kBed.depth);
  const double frame = random.uniform(0.22, 0.32);
  const double mattress = random.uniform(0.16, 0.24);
  const double head = random.uniform(0.75, 1.1);
  const Spot middle = spot.relative((length - kind::kBed.depth) / 2, 0);
  builder.box(middle, {length, width, frame}, when);
  builder.box(middle.relative(0.01, 0, 0, frame), {length - 0.1, width - 0.08, mattress}, when);
  builder.box(middle.relative(-length / 2 + 0.025, 0), {0.05, width, head}, when);
  if (chance(random, 0.5))
    builder.box(middle.relative(length / 2 - 0.02, 0), {0.04, width, frame + mattress + 0.1}, when);
  const Spot mattress_top = middle.relative(0, 0, 0, frame + mattress);
  const bool slept_in = when == When::always && chance(random, 0.5);
  addBedding(builder, mattress_top, length, width, random, slept_in ? When::mapped : when);
  if (slept_in) addBedding(builder, mattress_top, length, width, random, When::later);
}

void addBedsideTable(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const auto [depth, width, height, middle] = drawn(kind::kBedsideTable, spot, 0.32, 0.35, 0.42, 0.6, random);
  addCarcass(builder, middle, depth, width, height, 1, when, Material::matt);
  const Spot top = middle.relative(-0.04, 0.03, 0, height);
  builder.cylinder(top, 0.015, 0.2, when);
  builder.cylinder(top.relative(0, 0, 0, 0.2), 0.11, 0.17, when);
}

// ---- Kitchens and bathrooms ----

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

}  // namespace

namespace kind {
const Kind kDesk{addDesk, 0.8, 1.6};
const Kind kChair{addChair, 0.6, 0.6};
const Kind kTable{addTable, 0.9, 1.7};
const Kind kRoundTable{addRoundTable, 1.2, 1.2};
const Kind kCoffeeTable{addCoffeeTable, 0.65, 1.1};
const Kind kCupboard{addCupboard, 0.45, 1.2, true};
const Kind kSideboard{addSideboard, 0.45, 1.7};
const Kind kWardrobe{addWardrobe, 0.62, 1.7, true};
const Kind kShoeCupboard{addShoeCupboard, 0.3, 1.0};
const Kind kBookcase{addBookcase, 0.35, 1.0, true};
const Kind kSofa{addSofa, 0.95, 2.1};
const Kind kArmchair{addArmchair, 0.9, 0.9};
const Kind kTvStand{addTvStand, 0.45, 1.6};
const Kind kBed{addBed, 2.1, 1.65};
const Kind kBedsideTable{addBedsideTable, 0.42, 0.45};
const Kind kLamp{addLamp, 0.44, 0.44, true};
const Kind kBin{addBin, 0.36, 0.36};
const Kind kPlant{addPlant, 0.8, 0.8, true};
const Kind kPerson{addPerson, 0.44, 0.6, true};
const Kind kCoats{addCoats, 0.3, 0.9, true};
const Kind kRadiator{addRadiator, 0.15, 1.2};
const Kind kCarton{addCarton, 0.6, 0.6};
const Kind kKitchenUnit{addKitchenUnit, 0.64, 2.4};
const Kind kFridge{addFridge, 0.66, 0.6, true};
const Kind kBathtub{addBathtub, 0.75, 1.7};
const Kind kToilet{addToilet, 0.68, 0.4};
const Kind kWashbasin{addWashbasin, 0.5, 0.65};
const Kind kWashingMachine{addWashingMachine, 0.62, 0.6};
}  // namespace kind

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
