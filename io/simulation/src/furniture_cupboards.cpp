// SPDX-License-Identifier: BSD-3-Clause
// Cupboards, chests and bookcases.
#include "furniture.h"
#include "furniture_parts.h"

#include <vector>

namespace facetloc {

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

}  // namespace facetloc
