// SPDX-License-Identifier: BSD-3-Clause
// Built-in things, fitted to the place.
#include "furniture.h"
#include "furniture_parts.h"

namespace facetloc {

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
