// SPDX-License-Identifier: BSD-3-Clause
#include "furniture_parts.h"

#include <facetloc/features/pose.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace facetloc {
namespace {

// ---- On the floor ----

/** A wooden pallet: three runners, a deck. */
void addPalletWood(SceneBuilder& builder, const Spot& spot, double depth, double width, When when) {
  for (int i = -1; i <= 1; ++i)
    builder.box(spot.relative(0, i * (width / 2 - 0.05)), {depth, 0.1, 0.12}, when);
  builder.box(spot.relative(0, 0, 0, 0.12), {depth, width, 0.024}, when);
}

constexpr double kPalletHeight = 0.144;

/** Layers of equal cartons, as they come from a maker; the last layer is not full. */
void addStack(SceneBuilder& builder, const Spot& spot, double depth, double width, double max_height,
              Random& random, When when) {
  const int along = count(random, 1, 3), across = count(random, 1, 2);
  const double high = random.uniform(0.25, 0.5);
  const int layers = count(random, 1, std::max(1, static_cast<int>(max_height / high)));
  const double share = random.uniform(0.4, 1);
  const double a = depth / along, b = width / across;
  for (int k = 0; k < layers; ++k) {
    for (int i = 0; i < along * across; ++i) {
      const double turn = random.uniform(-2.5, 2.5) * kDegree;
      const double shrink = random.uniform(0.93, 0.985);
      const bool there = chance(random, share);
      if (k + 1 == layers && k > 0 && !there) continue;
      builder.box(spot.relative((i / across + 0.5) * a - depth / 2, (i % across + 0.5) * b - width / 2, turn,
                                k * high),
                  {a * shrink, b * shrink, high}, when);
    }
  }
}

void addPallet(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  constexpr double kDepth = 1.2, kWidth = 0.8, kFreight = 1.5;  // Euro pallets, and the freight's height [m]
  addPalletWood(builder, spot, kDepth, kWidth, when);
  const double freight = random.uniform();
  const Spot deck = spot.relative(0, 0, 0, kPalletHeight);
  if (freight < 0.1) {  // a pile of empty ones
    const int more = count(random, 1, 6);
    for (int i = 1; i <= more; ++i)
      addPalletWood(builder, spot.relative(0, 0, random.uniform(-2, 2) * kDegree, i * kPalletHeight), kDepth,
                    kWidth, when);
  } else if (freight < 0.25) {  // drums
    for (const double x : {-0.3, 0.3}) {
      const double height = random.uniform(0.6, 0.9);
      builder.cylinder(deck.relative(x, random.uniform(-0.05, 0.05)), 0.28, height, when);
    }
  } else if (freight < 0.35) {              // a lattice box
    const bool dark = chance(random, 0.5);  // one draw per statement: else the compiler chooses the order
    const double height = random.uniform(0.6, 0.9);
    builder.box(deck, {kDepth, kWidth, height}, when, darkIf(dark));
  } else {
    addStack(builder, deck, kDepth, kWidth, kFreight, random, when);
  }
}

void addMachine(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const double depth = random.uniform(1.0, kind::kMachine.depth - 0.2);
  const double width = random.uniform(1.5, kind::kMachine.width);
  const double base = random.uniform(0.5, 0.9);
  const double height = random.uniform(1.5, 2.4);
  const int side = chance(random, 0.5) ? 1 : -1;
  const double body = random.uniform(0.4, 0.65) * width;
  const Material material = darkIf(chance(random, 0.2));
  const Spot middle = spot.relative((depth - kind::kMachine.depth) / 2, 0);
  builder.box(middle, {depth, width, base}, when, material);
  builder.box(middle.relative(-0.1 * depth, side * (width - body) / 2, 0, base),
              {0.8 * depth, body, height - base}, when, material);
  // A hood that slopes to the front over the bed, a window in the body, a control panel on an arm.
  slab(builder, middle.relative(0, -side * body / 2), base + 0.35, random.uniform(-60, -30),
       {0.02, width - body - 0.06, 0.7 * depth}, when);
  builder.box(middle.relative(0.3 * depth + 0.01, side * (width - body) / 2, 0, base + 0.15),
              {0.02, 0.7 * body, 0.5 * (height - base)}, when, Material::glass);
  const Spot panel =
      middle.relative(depth / 2 - 0.15, -side * (width / 2 - 0.2), random.uniform(-40, 40) * kDegree);
  builder.cylinder(panel.relative(0, 0, 0, base), 0.03, 1.3 - base, when);
  slab(builder, panel, 1.35, -20, {0.08, 0.35, 0.3}, when, Material::dark);
  if (chance(random, 0.6)) {
    const double radius = random.uniform(0.12, 0.25);
    builder.cylinder(middle.relative(-depth / 4, side * (width / 2 - 0.4), 0, height), radius, 0.4, when);
  }
}

void addWorkbench(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const auto [depth, width, height, middle] = drawn(kind::kWorkbench, spot, 0.65, 1.4, 0.82, 0.95, random);
  builder.box(middle.relative(0, 0, 0, height - 0.05), {depth, width, 0.05}, when);
  legs(builder, middle, depth, width, height - 0.05, 0.08, when);
  builder.box(middle.relative(0, width / 4, 0, 0.15), {depth - 0.15, 0.42, height - 0.25}, when);
  builder.box(middle.relative(0, -width / 8, 0, 0.2), {depth - 0.2, 0.6 * width, 0.03}, when);
  if (chance(random, 0.6))  // a panel for tools at its back
    builder.box(middle.relative(-depth / 2 + 0.02, 0, 0, height), {0.03, width, random.uniform(0.5, 0.9)},
                when);
  builder.box(middle.relative(0.2, -width / 3, random.uniform(-20, 20) * kDegree, height), {0.3, 0.16, 0.18},
              when, Material::dark);
  addOddments(builder, middle.relative(0, 0, 0, height), depth, width, count(random, 2, 5), random, when);
}

void addForklift(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  constexpr double kWidth = 1.1;
  const double mast = random.uniform(2.0, 2.3);
  const double lift = random.uniform(0.06, 0.5);
  // Counterweight, bonnet, footwell, from the rear to the front.
  builder.box(spot.relative(-1.2, 0, 0, 0.2), {0.5, kWidth, 0.85}, when, Material::dark);
  builder.box(spot.relative(-0.65, 0, 0, 0.2), {0.6, kWidth, 0.75}, when);
  builder.box(spot.relative(0, 0, 0, 0.2), {0.7, kWidth, 0.3}, when);
  builder.box(spot.relative(-0.55, 0, 0, 0.95), {0.45, 0.5, 0.1}, when, Material::dark);
  slab(builder, spot.relative(-0.85, 0), 1.35, -10, {0.08, 0.45, 0.55}, when, Material::dark);
  for (const double x : {-1.0, 0.15})
    for (const int side : {-1, 1})
      builder.box(spot.relative(x, side * (kWidth / 2 - 0.13)), {0.5, 0.22, 0.5}, when, Material::dark);
  for (const double x : {-1.0, 0.3})  // the guard above the driver
    for (const int side : {-1, 1})
      builder.box(spot.relative(x, side * (kWidth / 2 - 0.05), 0, 0.5), {0.06, 0.06, 1.5}, when);
  builder.box(spot.relative(-0.35, 0, 0, 2.0), {1.4, kWidth, 0.05}, when);
  for (const int side : {-1, 1}) {
    builder.box(spot.relative(0.45, side * 0.3), {0.12, 0.1, mast}, when);
    builder.box(spot.relative(1.02, side * 0.28, 0, lift), {1.0, 0.12, 0.04}, when);
  }
  builder.box(spot.relative(0.53, 0, 0, lift), {0.05, 0.9, 0.5}, when);
}

void addTrolley(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const double depth = random.uniform(0.8, kind::kTrolley.depth - 0.1), width = kind::kTrolley.width - 0.05;
  builder.box(spot.relative(0, 0, 0, 0.15), {depth, width, 0.04}, when);
  for (const int x : {-1, 1})
    for (const int y : {-1, 1})
      builder.cylinder(spot.relative(x * (depth / 2 - 0.1), y * (width / 2 - 0.08)), 0.05, 0.15, when,
                       Material::dark);
  for (const int y : {-1, 1})
    slab(builder, spot.relative(-depth / 2 - 0.02, y * (width / 2 - 0.03)), 0.55, -6, {0.03, 0.03, 0.8},
         when);
  slab(builder, spot.relative(-depth / 2 - 0.06, 0), 0.95, -6, {0.03, width, 0.03}, when);
  if (chance(random, 0.7))
    addStack(builder, spot.relative(0, 0, 0, 0.19), depth - 0.08, width - 0.06, 0.8, random, when);
}

void addBarrels(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  constexpr double kRadius = 0.29, kHeight = 0.88;
  const int number = count(random, 1, 4);
  for (int i = 0; i < number; ++i) {
    const double x = (i % 2 ? 0.31 : -0.31) + random.uniform(-0.015, 0.015);
    const double y = (i / 2 ? 0.31 : -0.31) + random.uniform(-0.015, 0.015);
    builder.cylinder(spot.relative(x, y), kRadius, kHeight, when);
  }
}

void addStepladder(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  constexpr double kLean = 18, kStile = 0.03;  // [deg], [m]
  const double length = random.uniform(1.4, 1.9);
  const double foot = length * std::sin(kLean * kDegree) / 2;
  const double middle = length * std::cos(kLean * kDegree) / 2;
  for (const int side : {-1, 1}) {
    const double width = side > 0 ? 0.5 : 0.44;
    for (const int y : {-1, 1})
      slab(builder, spot.relative(side * foot, y * width / 2), middle, -side * kLean, {0.06, kStile, length},
           when);
    if (side < 0) continue;
    const int steps = static_cast<int>(length / 0.25);
    for (int i = 1; i < steps; ++i) {
      const double share = static_cast<double>(i) / steps;
      builder.box(spot.relative(2 * foot * (1 - share), 0, 0, 2 * middle * share),
                  {0.1, width - kStile, 0.025}, when);
    }
  }
  builder.box(spot.relative(0, 0, 0, 2 * middle), {0.22, 0.5, 0.03}, when);
}

void addLocker(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const int doors = count(random, 2, 4);
  const double width = doors * 0.3, height = random.uniform(1.75, 1.9);
  addCarcass(builder, spot, kind::kLocker.depth, width, height, doors, when,
             darkIf(chance(random, kDarkCupboards)));
  if (chance(random, 0.4)) builder.box(spot.relative(0, 0.1, 0.2, height), {0.3, 0.4, 0.25}, when);
}

// ---- Racks ----

/** One thing on a board: it stays, is taken away, comes new, or is pushed aside. */
template <class Add>
void addLoad(double moved_share, double slack, Random& random, Add&& add) {
  const double fate = random.uniform() / moved_share;
  const double push = slack * random.uniform(-1, 1);
  if (fate >= 1) return add(0.0, When::always);
  if (fate < 0.35) return add(0.0, When::mapped);
  if (fate < 0.7) return add(0.0, When::later);
  add(0.0, When::mapped);
  add(push, When::later);
}

void loadCartons(SceneBuilder& builder, const Spot& board, double depth, double width, double height,
                 double moved_share, Random& random) {
  for (double y = -width / 2 + 0.04;;) {
    if (chance(random, 0.25)) y += random.uniform(0.1, 0.5);
    const double wide = random.uniform(0.22, 0.65);
    const double deep = random.uniform(0.45, 0.95) * depth;
    const double high = random.uniform(0.3, 0.92) * height;
    const double pushed = random.uniform(0, depth - deep);
    const double turn = random.uniform(-5, 5) * kDegree;
    constexpr double kSlack = 0.04;  // [m]
    if (y + wide + kSlack > width / 2) return;
    const Spot spot = board.relative(depth / 2 - deep / 2 - pushed, y + wide / 2, turn);
    addLoad(moved_share, kSlack, random, [&](double push, When when) {
      builder.box(spot.relative(push, push / 2, push), {deep, wide, high}, when);
    });
    y += wide + random.uniform(0.02, 0.1);
  }
}

void loadCrates(SceneBuilder& builder, const Spot& board, double depth, double width, double height,
                double moved_share, Random& random) {
  constexpr double kWide = 0.4, kDeep = 0.6, kPitch = 0.45;
  const double high = std::min(0.32, 0.9 * height);
  for (double y = -width / 2 + kPitch / 2; y + kPitch / 2 <= width / 2; y += kPitch) {
    const bool there = chance(random, 0.8);
    const double in = random.uniform(0, 0.06);
    if (!there) continue;
    const Spot spot = board.relative(depth / 2 - std::min(kDeep, depth) / 2 - in, y);
    addLoad(moved_share, 0.04, random, [&](double push, When when) {
      builder.box(spot.relative(-std::abs(push), 0, push), {std::min(kDeep, depth - 0.06), kWide, high},
                  when);
    });
  }
}

void loadRolls(SceneBuilder& builder, const Spot& board, double depth, double width, double height,
               double moved_share, Random& random) {
  const double radius = std::min(random.uniform(0.12, 0.22), 0.4 * depth);
  for (double y = -width / 2 + radius + 0.05; y + radius < width / 2; y += 2 * radius + 0.06) {
    const double high = random.uniform(0.4, 0.9) * height;
    const double in = random.uniform(0, 0.2 * depth);
    const bool there = chance(random, 0.8);
    if (!there) continue;
    const Spot spot = board.relative(depth / 2 - radius - in, y);
    addLoad(moved_share, 0.02, random, [&](double push, When when) {
      builder.cylinder(spot.relative(-push, push), radius, high, when);
    });
  }
}

/** The freight of one bay, the only difference between the bays of equal racks: it loads a board. */
using Freight = decltype(loadCartons);

/** Null for none. */
Freight* drawFreight(Random& random) {
  const double draw = random.uniform();
  if (draw < 0.55) return loadCartons;
  if (draw < 0.8) return loadCrates;
  return draw < 0.9 ? loadRolls : nullptr;
}

}  // namespace

namespace kind {
const Kind kPallet{addPallet, 1.25, 0.85};
const Kind kMachine{addMachine, 1.5, 2.4, true};
const Kind kWorkbench{addWorkbench, 0.8, 2.0};
const Kind kForklift{addForklift, 3.2, 1.2, true};
const Kind kTrolley{addTrolley, 1.0, 0.6};
const Kind kBarrels{addBarrels, 1.25, 1.25};
const Kind kStepladder{addStepladder, 1.4, 0.6};
const Kind kLocker{addLocker, 0.5, 1.2, true};
}  // namespace kind

void addRackRow(SceneBuilder& builder, const Spot& spot, const RackRow& rack, Random& random) {
  constexpr double kPost = 0.07, kBoardThickness = 0.04, kLowest = 0.1, kLip = 0.08;  // [m]
  const double bay = rack.length / rack.bays;
  for (int i = 0; i <= rack.bays; ++i) {
    const double y = (i - 0.5 * rack.bays) * bay;
    for (const int side : {-1, 1})
      builder.box(spot.relative(side * (rack.depth - kPost) / 2, y), {kPost, kPost, rack.height});
    // Braces between the posts, which slope up and down by turns.
    const double rise = 0.9, length = std::hypot(rise, rack.depth - kPost);
    int sign = 1;
    for (double z = 0.3; z + rise < rack.height; z += rise, sign = -sign)
      slab(builder, spot.relative(0, y), z + rise / 2, sign * std::acos(rise / length) / kDegree,
           {0.04, 0.02, length}, When::always);
  }
  const double free = rack.board_distance - kBoardThickness - 0.03;
  std::vector<Freight*> freight;
  for (int i = 0; i < rack.bays; ++i) freight.push_back(drawFreight(random));
  for (double z = kLowest; z + kBoardThickness < rack.height; z += rack.board_distance) {
    // Boards run through, with a beam along each edge.
    builder.box(spot.relative(0, 0, 0, z), {rack.depth - 0.02, rack.length, kBoardThickness});
    for (const int side : {-1, 1})
      builder.box(spot.relative(side * (rack.depth / 2 - 0.01), 0, 0, z + kBoardThickness - kLip),
                  {0.03, rack.length, kLip});
    for (int i = 0; i < rack.bays; ++i) {
      const bool odd_one = chance(random, 0.2);
      Freight* odd = drawFreight(random);
      const Spot board = spot.relative(0, (i + 0.5 - 0.5 * rack.bays) * bay, 0, z + kBoardThickness);
      const double width = bay - kPost, depth = rack.depth - 0.04;
      if (Freight* load = odd_one ? odd : freight[i])
        load(builder, board, depth, width, free, rack.moved_share, random);
    }
  }
}

}  // namespace facetloc
