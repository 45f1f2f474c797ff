// SPDX-License-Identifier: BSD-3-Clause
// Things that stand or hang about in any room, and people.
#include "furniture.h"
#include "furniture_parts.h"

#include <facetloc/features/pose.h>

#include <cmath>

namespace facetloc {

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

}  // namespace facetloc
