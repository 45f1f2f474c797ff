// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "furniture.h"

#include <vector>

namespace facetloc {

// Parts of furniture, and small things on it. Lengths in metres; things stand on their
// spot and look along its x axis: depth is along x, width along y.

constexpr double kBoard = 0.02;                                                 // thickness of boards
constexpr double kDarkCupboards = 0.15, kDarkSofas = 0.3, kDarkClothes = 0.35;  // shares

inline Material darkIf(bool dark) { return dark ? Material::dark : Material::matt; }

inline bool chance(Random& random, double probability) { return random.uniform() < probability; }

/** \brief Random number from least to most, both included. */
inline int count(Random& random, int least, int most) {
  return least + static_cast<int>((most - least + 1) * random.uniform());
}

/** \brief A thing with its back where its kind's is: its sizes and its middle. */
struct Drawn {
  double depth, width, height;
  Spot middle;
};
/** \brief Draws depth and width, from the least up to those of the kind, and the height. */
inline Drawn drawn(const Kind& kind, const Spot& spot, double least_depth, double least_width,
                   double least_height, double most_height, Random& random) {
  const double depth = random.uniform(least_depth, kind.depth);
  const double width = random.uniform(least_width, kind.width);
  return {depth, width, random.uniform(least_height, most_height),
          spot.relative((depth - kind.depth) / 2, 0)};
}

/** \brief A box that leans: pitched about the y axis of its spot, to the front if positive, after its middle
 * was put at height z above the spot. */
void slab(SceneBuilder& builder, const Spot& spot, double z, double pitch_deg, const Eigen::Vector3d& size,
          When when, Material material = Material::matt);

/** \brief Four legs under a top, each of a square of that side; the spot is in the middle, on the floor. */
void legs(SceneBuilder& builder, const Spot& spot, double depth, double width, double height, double side,
          When when);

/** \brief Small things on a board or a table top: boxes, jars, bowls. Those on immovable furniture are used
 * now and then. */
void addOddments(SceneBuilder& builder, const Spot& on_top, double depth, double width, int number,
                 Random& random, When when);

/** \brief A screen on its foot; seen along x. */
void addScreen(SceneBuilder& builder, const Spot& on_top, double width, Random& random, When when);

/** \brief Books along a board, in groups of the same size, with gaps; some lie. Of those on immovable
 * furniture some are taken away. */
void addBooks(SceneBuilder& builder, const Spot& board, double depth, double width, double height,
              Random& random, When when);

/** \brief A carcass of boards that is open to the front, about so far apart.
 * \return the heights of their upper faces, from below. */
std::vector<double> addOpenShelf(SceneBuilder& builder, const Spot& spot, double depth, double width,
                                 double height, double distance, When when);

/** \brief A closed box with a plinth, a top that juts out, and handles. */
void addCarcass(SceneBuilder& builder, const Spot& spot, double depth, double width, double height, int doors,
                When when, Material material);

}  // namespace facetloc
