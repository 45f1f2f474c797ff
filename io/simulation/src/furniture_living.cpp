// SPDX-License-Identifier: BSD-3-Clause
// Living rooms and bedrooms: seats, a television, beds.
#include "furniture.h"
#include "furniture_parts.h"

#include <facetloc/features/pose.h>

namespace facetloc {

namespace {

/** The common parts of sofas and armchairs: arms, a back that leans, seat cushions. */
void addSeat(SceneBuilder& builder, const Spot& spot, double depth, double width, int cushions,
             Random& random, When when) {
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

}  // namespace

void addSofa(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const double depth = random.uniform(0.82, kind::kSofa.depth);
  const double width = random.uniform(1.6, kind::kSofa.width);
  addSeat(builder, spot.relative((depth - kind::kSofa.depth) / 2, 0), depth, width, width > 1.85 ? 3 : 2,
          random, when);
}

void addArmchair(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const double depth = random.uniform(0.75, kind::kArmchair.depth);
  const double width = random.uniform(0.75, kind::kArmchair.width);
  addSeat(builder, spot.relative((depth - kind::kArmchair.depth) / 2, 0), depth, width, 1, random, when);
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

namespace {

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

}  // namespace

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

}  // namespace facetloc
