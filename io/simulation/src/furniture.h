// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scene_builder.h"

namespace facetloc {

// Things that stand about, built of boxes and round bodies. Each is centred on its spot, its front looks
// along the spot's x axis; sizes vary with the random numbers. A thing that is mapped and later moved is
// added twice, with the same sizes: pass a copy of the random numbers' state.

using AddThing = void(SceneBuilder&, const Spot&, Random&, When);

/** \brief A kind of thing and the floor that it needs: depth along the x axis of its spot, width along y [m].
 * Single things may be smaller; the back of a thing at a wall is always at x = -depth / 2. */
struct Kind {
  AddThing* add;
  double depth;
  double width;
  bool tall = false;  ///< hides pictures and boards on the wall behind it
};

// ---- Offices and homes ----
AddThing addDesk;   // with a screen
AddThing addChair;  // with its back
AddThing addTable;
AddThing addRoundTable;
AddThing addCoffeeTable;
AddThing addCupboard;  // closed
AddThing addSideboard;
AddThing addWardrobe;
AddThing addShoeCupboard;
AddThing addBookcase;
AddThing addSofa;
AddThing addArmchair;
AddThing addTvStand;
AddThing addBed;  // head at its back
AddThing addBedsideTable;
AddThing addLamp;
AddThing addBin;  // round or square
AddThing addPlant;
AddThing addPerson;
AddThing addRadiator;
AddThing addCoats;  // on hooks
AddThing addCarton;

// ---- Kitchens and bathrooms ----
AddThing addKitchenUnit;
AddThing addFridge;
AddThing addBathtub;
AddThing addToilet;
AddThing addWashbasin;
AddThing addWashingMachine;

// ---- Halls ----
AddThing addPallet;  // with boxes
AddThing addMachine;
AddThing addWorkbench;
AddThing addForklift;
AddThing addTrolley;
AddThing addBarrels;
AddThing addStepladder;
AddThing addLocker;

namespace kind {
constexpr Kind kDesk{addDesk, 0.8, 1.6};
constexpr Kind kChair{addChair, 0.6, 0.6};
constexpr Kind kTable{addTable, 0.9, 1.7};
constexpr Kind kRoundTable{addRoundTable, 1.2, 1.2};
constexpr Kind kCoffeeTable{addCoffeeTable, 0.65, 1.1};
constexpr Kind kCupboard{addCupboard, 0.45, 1.2, true};
constexpr Kind kSideboard{addSideboard, 0.45, 1.7};
constexpr Kind kWardrobe{addWardrobe, 0.62, 1.7, true};
constexpr Kind kShoeCupboard{addShoeCupboard, 0.3, 1.0};
constexpr Kind kBookcase{addBookcase, 0.35, 1.0, true};
constexpr Kind kSofa{addSofa, 0.95, 2.1};
constexpr Kind kArmchair{addArmchair, 0.9, 0.9};
constexpr Kind kTvStand{addTvStand, 0.45, 1.6};
constexpr Kind kBed{addBed, 2.1, 1.65};
constexpr Kind kBedsideTable{addBedsideTable, 0.42, 0.45};
constexpr Kind kLamp{addLamp, 0.44, 0.44, true};
constexpr Kind kBin{addBin, 0.36, 0.36};
constexpr Kind kPlant{addPlant, 0.8, 0.8, true};
constexpr Kind kPerson{addPerson, 0.44, 0.6, true};
constexpr Kind kCoats{addCoats, 0.3, 0.9, true};
constexpr Kind kRadiator{addRadiator, 0.15, 1.2};
constexpr Kind kCarton{addCarton, 0.6, 0.6};
constexpr Kind kKitchenUnit{addKitchenUnit, 0.64, 2.4};
constexpr Kind kFridge{addFridge, 0.66, 0.6, true};
constexpr Kind kBathtub{addBathtub, 0.75, 1.7};
constexpr Kind kToilet{addToilet, 0.68, 0.4};
constexpr Kind kWashbasin{addWashbasin, 0.5, 0.65};
constexpr Kind kWashingMachine{addWashingMachine, 0.62, 0.6};
constexpr Kind kPallet{addPallet, 1.25, 0.85};
constexpr Kind kMachine{addMachine, 1.5, 2.4, true};
constexpr Kind kWorkbench{addWorkbench, 0.8, 2.0};
constexpr Kind kForklift{addForklift, 3.2, 1.2, true};
constexpr Kind kTrolley{addTrolley, 1.0, 0.6};
constexpr Kind kBarrels{addBarrels, 1.25, 1.25};
constexpr Kind kStepladder{addStepladder, 1.4, 0.6};
constexpr Kind kLocker{addLocker, 0.5, 1.2, true};
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
