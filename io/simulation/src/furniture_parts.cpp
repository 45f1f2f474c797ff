// SPDX-License-Identifier: BSD-3-Clause
#include "furniture_parts.h"

#include <facetloc/features/pose.h>

#include <algorithm>
#include <cmath>

namespace facetloc {
namespace {

using Eigen::Vector3d;

constexpr double kHandled = 0.25;  // share of small things that are elsewhere when the robot comes back

void addOddment(SceneBuilder& builder, const Spot& spot, Random& random, When when) {
  const double a = random.uniform(0.08, 0.2), b = random.uniform(0.08, 0.2), c = random.uniform(0.06, 0.3);
  const double shape = random.uniform();
  if (shape < 0.6) {
    builder.box(spot, {a, b, c}, when);
  } else if (shape < 0.8) {
    builder.cylinder(spot, a / 2, c, when);
  } else {
    builder.ellipsoid(spot, a / 2, {a / 2, a / 2, a / 2}, when);
  }
}

}  // namespace

void slab(SceneBuilder& builder, const Spot& spot, double z, double pitch_deg, const Vector3d& size,
          When when, Material material) {
  builder.box(spot.pose() * Eigen::Translation3d(0, 0, z) *
                  Eigen::AngleAxisd(pitch_deg * kDegree, Vector3d::UnitY()),
              size, when, material);
}

void legs(SceneBuilder& builder, const Spot& spot, double depth, double width, double height, double side,
          When when) {
  for (const int x : {-1, 1})
    for (const int y : {-1, 1})
      builder.box(spot.relative(x * (depth - side) / 2, y * (width - side) / 2), {side, side, height}, when);
}

void addOddments(SceneBuilder& builder, const Spot& on_top, double depth, double width, int number,
                 Random& random, When when) {
  constexpr double kLargest = 0.26;  // [m]
  if (depth < kLargest || width < kLargest) return;
  for (int i = 0; i < number; ++i) {
    const auto draw_spot = [&] {
      const double x = random.uniform(-0.5, 0.5) * (depth - kLargest);
      const double y = (i + 0.5 + random.uniform(-0.2, 0.2)) / number * width - width / 2;
      return on_top.relative(x, y, random.uniform(-40, 40) * kDegree);
    };
    const Spot first = draw_spot();
    const Spot second = draw_spot();
    const bool handled = chance(random, kHandled);
    if (when == When::always && handled) {
      Random again = random;
      addOddment(builder, second, again, When::later);
      addOddment(builder, first, random, When::mapped);
    } else {
      addOddment(builder, first, random, when);
    }
  }
}

void addScreen(SceneBuilder& builder, const Spot& on_top, double width, Random& random, When when) {
  const double lean = random.uniform(-12, -2);
  const double height = 0.58 * width;
  const double gap = random.uniform(0.08, 0.14);
  builder.box(on_top, {0.16, 0.24, 0.015}, when, Material::dark);
  builder.box(on_top.relative(-0.04, 0, 0, 0.015), {0.03, 0.06, gap}, when, Material::dark);
  slab(builder, on_top, gap + height / 2, lean, {0.035, width, height}, when, Material::dark);
}

void addBooks(SceneBuilder& builder, const Spot& board, double depth, double width, double height,
              Random& random, When when) {
  double y = -width / 2;
  while (true) {
    if (chance(random, 0.3)) y += random.uniform(0.05, 0.35);
    const double group = random.uniform(0.07, 0.32);
    const double tall = height * random.uniform(0.55, 0.92);
    const double deep = depth * random.uniform(0.5, 0.9);
    const double pushed = random.uniform(0, depth - deep);
    const bool lies = chance(random, 0.12);
    const bool handled = when == When::always && chance(random, kHandled / 2);
    if (y + group > width / 2) return;
    const Spot spot = board.relative(depth / 2 - deep / 2 - pushed, y + group / 2);
    builder.box(spot, {deep, group, lies ? tall / 2 : tall}, handled ? When::mapped : when);
    y += group;
  }
}

std::vector<double> addOpenShelf(SceneBuilder& builder, const Spot& spot, double depth, double width,
                                 double height, double distance, When when) {
  const double inner = width - 2 * kBoard;
  for (const int side : {-1, 1})
    builder.box(spot.relative(0, side * (width - kBoard) / 2), {depth, kBoard, height}, when);
  builder.box(spot.relative(-depth / 2 + 0.005, 0), {0.01, inner, height}, when);
  const int boards = std::max(2, static_cast<int>(std::lround(height / distance)) + 1);
  constexpr double kPlinth = 0.06;
  std::vector<double> tops;
  for (int i = 0; i < boards; ++i) {
    const double z = kPlinth + i * (height - kPlinth - kBoard) / (boards - 1);
    builder.box(spot.relative(0, 0, 0, z), {depth - 0.01, inner, kBoard}, when);
    tops.push_back(z + kBoard);
  }
  return tops;
}

void addCarcass(SceneBuilder& builder, const Spot& spot, double depth, double width, double height, int doors,
                When when, Material material) {
  constexpr double kPlinth = 0.08, kRecess = 0.04, kTop = 0.025, kJut = 0.015, kHandle = 0.02;
  builder.box(spot.relative(-kRecess / 2, 0), {depth - kJut - kRecess, width - 0.02, kPlinth}, when,
              material);
  builder.box(spot.relative(-kJut / 2, 0, 0, kPlinth), {depth - kJut, width, height - kPlinth - kTop}, when,
              material);
  builder.box(spot.relative(0, 0, 0, height - kTop), {depth, width, kTop}, when, material);
  for (int i = 0; i < doors; ++i) {
    const double y = (i + (i % 2 ? 0.12 : 0.88)) / doors * width - width / 2;
    const double z = std::min(height - 0.3, 1.0);
    builder.box(spot.relative(depth / 2 - kJut + kHandle / 2, y, 0, z), {kHandle, 0.02, 0.14}, when);
  }
}

}  // namespace facetloc
