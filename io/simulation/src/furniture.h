// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scene_builder.h"

namespace facetloc {

/** \brief A kind of thing that stands about, built of boxes and round bodies, and the floor that it needs:
 * depth along the x axis of its spot, width along y [m]. Single things may be smaller; the back of a thing at
 * a wall is always at x = -depth / 2. */
struct Kind {
  /** Adds one, centred on its spot; its front looks along the spot's x axis. Sizes vary with the random
   * numbers: a thing that is mapped and later moved is added twice, by copies of their state. */
  void (*add)(SceneBuilder& builder, const Spot& spot, Random& random, When when);
  double depth;
  double width;
  bool tall = false;  ///< hides pictures and boards on the wall behind it
};

namespace kind {
// ---- Offices and homes ----
extern const Kind kDesk, kChair, kTable, kRoundTable, kCoffeeTable, kCupboard, kSideboard, kWardrobe,
    kShoeCupboard, kBookcase, kSofa, kArmchair, kTvStand, kBed, kBedsideTable, kLamp, kBin, kPlant, kPerson,
    kRadiator, kCoats, kCarton;
// ---- Kitchens and bathrooms ----
extern const Kind kKitchenUnit, kFridge, kBathtub, kToilet, kWashbasin, kWashingMachine;
// ---- Halls ----
extern const Kind kPallet, kMachine, kWorkbench, kForklift, kTrolley, kBarrels, kStepladder, kLocker;
}  // namespace kind

// ---- Built-in things: fitted to the place, which gives their size ----

/** \brief A picture or notice board; its back is at the spot, which is on the wall, its foot at the spot's z.
 */
void addPicture(SceneBuilder& builder, const Spot& on_wall, double width, double height);
/** \brief The frame around a door, on one face of its wall; the spot is in the middle of the door, on that
 * face. */
void addDoorFrame(SceneBuilder& builder, const Spot& on_wall, double width, double height);
/** \brief A short board with a few things on it. */
void addWallShelf(SceneBuilder& builder, const Spot& on_wall, double width, Random& random);
/** \brief The folds of a curtain: upright half cylinders along the y axis of the spot. */
void addCurtain(SceneBuilder& builder, const Spot& on_wall, double width, double height, Random& random,
                When when = When::always);
/** \brief A lamp below the ceiling. */
void addPendantLamp(SceneBuilder& builder, const Spot& on_floor, double ceiling, Random& random);

/** \brief A row of racks along the y axis of the spot, its front along x, loaded. A share of the goods on the
 * boards is taken away, added or pushed aside between the runs. */
struct RackRow {
  double length = 10.8;         ///< [m]
  double depth = 0.9;           ///< [m]
  double height = 3.6;          ///< [m]
  double board_distance = 0.7;  ///< distance of the two runs of boards [m]
  int bays = 4;
  double moved_share = 0.15;
};
void addRackRow(SceneBuilder& builder, const Spot& spot, const RackRow& rack, Random& random);

}  // namespace facetloc
