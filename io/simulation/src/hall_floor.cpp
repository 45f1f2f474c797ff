// SPDX-License-Identifier: BSD-3-Clause
#include "floor_plan.h"
#include "furniture.h"
#include "scene_builder.h"

#include <facetloc/features/pose.h>

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace facetloc {
namespace {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;

constexpr int kBays = 4;

// Lengths in metres.
constexpr double kWall = 0.3;  // thickness
constexpr double kStoreHeight = 2.8;
constexpr double kDoorWidth = 1.1, kDoorHeight = 2.1, kLeafHeight = 2.08;
constexpr double kGateWidth = 3.2, kGateHeight = 3.6;

/** \brief A store: in the west two aisles between rows of racks, all equal but for the goods on them, and a
 * third one along a double row; in the east an open area with gates, machines and pallets, and a store room,
 * which is shut when the map is made.
 *
 *     +-------------------------------+
 *     |  machines and benches         |
 *     |            aisle 3            |
 *     | ==============                g
 *     | ==============   pallets      |
 *     |            aisle 2            |
 *     | ==============                g
 *     | ==============        +-------+
 *     |            aisle 1    | store |
 *     | ==============        | room  |
 *     +-----------------------+-------+
 *
 * Half of the halls are mirrored. */
class HallFloor : FurnishedFloor {
public:
  explicit HallFloor(std::uint64_t seed) : FurnishedFloor(seed, kFurniture) {}

  SimulatedPlace build() {
    drawSizes();
    drawRoutes();
    buildWalls();
    buildStoreRoom();
    buildRacks();
    buildColumns();
    buildBeams();
    furnishStoreRoom();
    furnishOpenArea();
    furnishAisles();
    addFixtures();
    addPeople();
    place_.unmapped_rooms = {store_};
    if (mirrored_) mirror(place_, hall_.max().x());
    return std::move(place_);
  }

private:
  enum Purpose : std::uint64_t { kSizes, kWays, kRacks, kFurniture };

  // Lengths in metres.
  static constexpr double kInnerWall = 0.14;   // thickness of the store room's walls
  static constexpr double kBackToBack = 0.12;  // between the two racks of a double row

  // ---- Sizes and ways ----
  void drawSizes() {
    Random random(derivedSeed(seed_, kSizes));
    const double width = random.uniform(23.5, 24.5), depth = random.uniform(15.6, 16.4);
    hall_ = {Vector2d(0, 0), Vector2d(width, depth)};
    ceiling_ = random.uniform(5.0, 6.0);
    rack_.depth = random.uniform(0.8, 1.0);
    rack_.length = kBays * random.uniform(2.0, 2.3);
    rack_.bays = kBays;
    rack_.height = random.uniform(3.0, 3.8);
    rack_.board_distance = random.uniform(0.55, 0.85);
    racks_west_ = random.uniform(2.7, 3.0);
    racks_east_ = racks_west_ + rack_.length;
    const double row = 2 * rack_.depth + kBackToBack;
    constexpr double kOffWall = 0.1;
    double y = kOffWall + rack_.depth;
    for (double* aisle : {&aisle_1_, &aisle_2_}) {
      const double wide = random.uniform(2.45, 2.85);
      *aisle = y + wide / 2;
      y += wide;
      rows_.push_back(y + row / 2);
      y += row;
    }
    aisle_3_ = y + 1.4;
    store_ = {Vector2d(width - random.uniform(5.4, 6.0), 0), Vector2d(width, random.uniform(4.0, 4.5))};
    mirrored_ = random.uniform() < 0.5;
    store_west_door_ = random.uniform(1.9, 2.3);
    store_north_door_ = width - random.uniform(2.5, 2.9);
  }

  /** The two ways pass the same places on different lines; only doors leave no choice. */
  void drawRoutes() {
    Random random(derivedSeed(seed_, kWays));
    const auto near = [&](double x, double y, double spread = 0.2) {
      const double dx = random.uniform(-spread, spread), dy = random.uniform(-spread, spread);
      return Waypoint{{x + dx, y + dy}, 0};
    };
    const double west = racks_west_ / 2, east = racks_east_ + 1.2;
    const double off = random.uniform(0.1, 0.25),
                 other = -random.uniform(0.1, 0.25);  // offset from the middle of aisles
    const double loop_east = store_north_door_, loop_south = aisle_2_ - 0.1, loop_north = aisle_3_ + 0.9;

    constexpr double kStraight = 0.05;  // aisles are driven along straight lines, nearly
    Route& mapping = place_.mapping_route;
    mapping = {near(east, aisle_1_ + off, kStraight),
               near(west, aisle_1_ + off, kStraight),
               near(west, aisle_2_ + off, kStraight),
               near(east, aisle_2_ + off, kStraight),
               near(loop_east - 2.0, loop_south - 0.3),
               near(loop_east, loop_south + 1.6),
               near(loop_east - 0.2, loop_north - 0.8),
               near(loop_east - 2.4, loop_north),
               near(east + 0.5, aisle_3_ + off, kStraight),
               near(west, aisle_3_ + off, kStraight),
               near(west - 0.1, aisle_1_ + off - 0.2, kStraight)};
    Route& query = place_.query_route;
    query = {near(west + 0.3, aisle_2_ + other, kStraight),
             near(east + 0.4, aisle_2_ + other, kStraight),
             near(store_.min().x() - 1.2, store_west_door_, kStraight),
             near(store_.min().x() + 1.1, store_west_door_, kStraight),
             near(store_north_door_, store_.max().y() - 0.9, kStraight),
             near(store_north_door_, store_.max().y() + 1.0, kStraight),
             near(loop_east - 0.3, loop_south + 1.8),
             near(loop_east + 0.15, loop_north - 0.6),
             near(loop_east - 2.0, loop_north + 0.3),
             near(east, aisle_3_ + other, kStraight),
             near(west + 0.3, aisle_3_ + other, kStraight),
             near(west + 0.3, aisle_1_ + other, kStraight),
             near(east + 0.3, aisle_1_ + other, kStraight),
             near(east + 0.3, aisle_2_ - 0.6, kStraight)};
    plan_.keepFree(mapping);
    plan_.keepFree(query);
  }

  // ---- Walls, gates and doors, columns and beams ----
  /** A roller gate in its opening, of slats that jut out by turns. */
  void buildGate(const Spot& inside) {
    constexpr int kSlats = 6;
    constexpr double kBehind = 0.12, kThickness = 0.03;
    const double slat = kGateHeight / kSlats;
    for (int i = 0; i < kSlats; ++i)
      builder_.box(inside.relative(-kBehind - (i % 2 ? kThickness : 0), 0, 0, i * slat),
                   {kThickness, kGateWidth, slat});
    for (const int side : {-1, 1}) {  // the rails, with bollards before them
      builder_.box(inside.relative(0.05, side * (kGateWidth / 2 + 0.06)), {0.1, 0.12, kGateHeight + 0.3});
      builder_.cylinder(inside.relative(0.35, side * (kGateWidth / 2 + 0.1)), 0.08, 1.0);
    }
    builder_.box(inside.relative(0.2, 0, 0, kGateHeight), {0.4, kGateWidth + 0.4, 0.4});
    constexpr double kApron = 1.6;
    plan_.take({inside.relative(kApron / 2, 0), kApron, kGateWidth + 0.5});
  }

  void shutDoor(const Spot& inside) {
    addDoorFrame(builder_, inside, kDoorWidth, kDoorHeight);
    const Spot leaf = inside.relative(-0.1, -kDoorWidth / 2, kPi / 2);
    builder_.doorLeaf(leaf.place, leaf.yaw, kDoorWidth, kDoorHeight);
    constexpr double kWay = 0.9;
    plan_.take({inside.relative(kWay / 2, 0), kWay, kDoorWidth});
  }

  /** A wall of the hall, its inner face from corner to corner, inside to the left, with gates, doors, and
   * pilasters between them. */
  void buildWall(const Vector2d& from, const Vector2d& to, const std::vector<double>& gates,
                 const std::vector<double>& doors) {
    const double length = (to - from).norm();
    const Vector2d along = (to - from) / length;
    const double yaw = std::atan2(along.x(), -along.y());
    const auto inside = [&](double s) { return Spot{from + s * along, yaw}; };
    std::vector<Opening> openings;
    for (const double gate : gates) {
      openings.push_back({gate + kWall, kGateWidth, 0, kGateHeight});
      buildGate(inside(gate));
    }
    for (const double door : doors) {
      openings.push_back({door + kWall, kDoorWidth, 0, kDoorHeight});
      shutDoor(inside(door));
    }
    const Vector2d out = inside(0).relative(-kWall / 2, 0).place - from;
    builder_.wall(from + out - kWall * along, to + out + kWall * along, kWall, ceiling_, openings);
    addPilasters(inside(0), length);
  }

  void addPilasters(const Spot& corner, double length) {
    constexpr double kDistance = 4.0, kDepth = 0.25, kWidth = 0.35;
    const int number = static_cast<int>(length / kDistance);
    for (int i = 1; i < number; ++i) {
      const Spot spot = corner.relative(kDepth / 2, -i * length / number);
      const Footprint footprint{spot, kDepth, kWidth};
      if (!plan_.isFree(footprint)) continue;
      builder_.pillar(spot, {kDepth, kWidth, ceiling_});
      plan_.take(footprint);
    }
  }

  void buildWalls() {
    const double w = hall_.max().x(), d = hall_.max().y();
    const auto vary = [&](double s) { return s + random_.uniform(-0.4, 0.4); };
    // Racks and the store room first: no pilasters in them.
    plan_.take({Spot{{(racks_west_ + racks_east_) / 2, rack_.depth / 2}, kPi / 2}, rack_.depth + 0.2,
                rack_.length + 0.3});
    buildWall({0, 0}, {w, 0}, {}, {vary(racks_east_ + 2.2)});
    buildWall({w, 0}, {w, d}, {vary(store_.max().y() + 3.0), vary(d - 3.2)}, {});
    buildWall({w, d}, {0, d}, {vary(0.25 * w)}, {vary(0.55 * w), vary(0.85 * w)});
    buildWall({0, d}, {0, 0}, {}, {vary(0.3 * d), vary(0.75 * d)});
    const AlignedBox2d all(Vector2d(-kWall, -kWall), Vector2d(w + kWall, d + kWall));
    builder_.level(all, 0);
    builder_.level(all, ceiling_);
  }

  /** Light walls with a lid, lower than the hall; its doors open into it. */
  void buildStoreRoom() {
    const Vector2d corner(store_.min().x(), store_.max().y());
    builder_.wall({corner.x(), 0}, corner, kInnerWall, kStoreHeight,
                  {{store_west_door_, kDoorWidth, 0, kDoorHeight}});
    builder_.wall(corner, store_.max(), kInnerWall, kStoreHeight,
                  {{store_north_door_ - corner.x(), kDoorWidth, 0, kDoorHeight}});
    builder_.level({store_.min(), store_.max() + Vector2d(0, kInnerWall / 2)}, kStoreHeight);
    const double half = kDoorWidth / 2;
    shutLeaf({corner.x() + 0.03, store_west_door_ - half}, kPi / 2, -1);
    shutLeaf({store_north_door_ + half, corner.y() - 0.03}, kPi, 1);
    for (const double turn : {0.0, kPi}) {
      addDoorFrame(builder_, Spot{{corner.x(), store_west_door_}, turn}.relative(kInnerWall / 2, 0),
                   kDoorWidth, kDoorHeight);
      addDoorFrame(builder_,
                   Spot{{store_north_door_, corner.y()}, turn + kPi / 2}.relative(kInnerWall / 2, 0),
                   kDoorWidth, kDoorHeight);
    }
    // Its walls, for things put up outside.
    const Vector2d middle = store_.center(), size = store_.sizes();
    plan_.take({Spot{{corner.x(), middle.y()}, 0}, kInnerWall, size.y()});
    plan_.take({Spot{{middle.x(), corner.y()}, 0}, size.x(), kInnerWall});
  }

  /** A leaf that is shut when the map is made, and open later. */
  void shutLeaf(const Vector2d& hinge, double closed, int sense) {
    const double leaf = kDoorWidth - 0.02;
    const double later = random_.uniform(92 * kDegree, 115 * kDegree);
    builder_.doorLeaf(hinge, closed, leaf, kLeafHeight, When::mapped);
    builder_.doorLeaf(hinge, closed + sense * later, leaf, kLeafHeight, When::later);
    const Spot open{hinge, closed + sense * kPi / 2};
    constexpr double kSwing = 0.5;
    plan_.take({open.relative(kDoorWidth / 2, sense * kSwing / 2), kDoorWidth, kSwing});
  }

  /** Columns on a grid, where nothing else stands; round ones in one row, square ones in the other. */
  void buildColumns() {
    constexpr double kSide = 0.36, kFoot = 0.5;
    const double y_round = rows_[0], y_square = rows_[1] + 0.3;
    for (double x = racks_east_ + 0.9; x < hall_.max().x() - 1.5; x += 4.4) {
      for (const bool round : {false, true}) {
        const double shift = random_.uniform(0, 0.6);
        const Spot spot{{x + shift, round ? y_round : y_square}, 0};
        const Footprint footprint{spot, kFoot, kFoot};
        if (!plan_.isFree(footprint)) continue;
        plan_.take(footprint);
        if (round) {
          builder_.roundPillar(spot, kSide / 2, ceiling_);
        } else {
          builder_.pillar(spot, {kSide, kSide, ceiling_});
        }
        if (random_.uniform() < 0.5) builder_.box(spot, {kFoot, kFoot, 0.25});
      }
    }
  }

  void buildBeams() {
    constexpr double kDistance = 4.0, kWidth = 0.3, kHeight = 0.55;
    for (double x = kDistance; x < hall_.max().x(); x += kDistance)
      builder_.box(Spot{{x, hall_.center().y()}, 0, ceiling_ - kHeight},
                   {kWidth, hall_.sizes().y(), kHeight});
  }

  // ---- Racks, and loose things ----
  void buildRack(double y, double yaw, Random& random) {
    const Spot spot{{(racks_west_ + racks_east_) / 2, y}, yaw};
    addRackRow(builder_, spot, rack_, random);
    plan_.take({spot, rack_.depth + 0.05, rack_.length + 0.1});
  }

  /** A low rail that guards the end of a row. */
  void addGuard(double x, double y, double width) {
    constexpr double kHeight = 0.4, kThickness = 0.1;
    const Spot spot{{x, y}, 0};
    builder_.box(spot.relative(0, 0, 0, kHeight - 0.15), {kThickness, width, 0.15});
    for (const int side : {-1, 1})
      builder_.box(spot.relative(0, side * (width / 2 - 0.1)), {0.08, 0.1, kHeight - 0.15});
    plan_.take({spot, kThickness, width});
  }

  void buildRacks() {
    Random random(derivedSeed(seed_, kRacks));
    buildRack(0.1 + rack_.depth / 2, kPi / 2, random);
    constexpr double kGuardGap = 0.25;
    for (const double row : rows_) {
      const double half = (rack_.depth + kBackToBack) / 2;
      buildRack(row - half, -kPi / 2, random);
      buildRack(row + half, kPi / 2, random);
      for (const double x : {racks_west_ - kGuardGap, racks_east_ + kGuardGap})
        addGuard(x, row, 2 * rack_.depth + kBackToBack);
    }
  }

  AlignedBox2d openArea() const {
    constexpr double kOffRacks = 0.4;
    return {Vector2d(racks_east_ + kOffRacks, 0), hall_.max()};
  }

  /** Pallets in rows, as a fork lift puts them down; some places are empty. */
  void addPalletBlock(const Vector2d& corner, int columns, int lines) {
    constexpr double kAlong = 1.45, kAcross = 1.0, kShareEmpty = 0.25;
    for (int i = 0; i < columns; ++i) {
      for (int j = 0; j < lines; ++j) {
        if (random_.uniform() < kShareEmpty) continue;
        const Spot spot{corner + Vector2d((i + 0.5) * kAlong, (j + 0.5) * kAcross), 0};
        furnisher_.at(kind::kPallet, spot, openArea(), true, 0.06, 4);
      }
    }
  }

  void furnishOpenArea() {
    const AlignedBox2d area = openArea();
    // Machines go along the walls, most of them in the north; pallets on the island inside the loop.
    const AlignedBox2d north(Vector2d(0.5, aisle_3_ + 1.2), hall_.max());
    for (int i = count(1, 2); i > 0; --i) furnisher_.atWall(kind::kMachine, north, false, 8);
    for (int i = count(2, 3); i > 0; --i) furnisher_.atWall(kind::kMachine, hall_, false, 3);
    for (int i = count(2, 3); i > 0; --i) furnisher_.atWall(kind::kWorkbench, hall_);
    furnisher_.anywhere(kind::kForklift, area);
    addPalletBlock({racks_east_ + 2.6, aisle_2_ + 0.9}, 3, 3);
    addPalletBlock({hall_.max().x() - 1.6, store_.max().y() + 0.3}, 1, 8);
    addPalletBlock({racks_east_ + 2.4, 0.4}, 2, 2);
    for (int i = count(1, 2); i > 0; --i) furnisher_.anywhere(kind::kMachine, area, false);
    for (int i = count(3, 5); i > 0; --i) furnisher_.anywhere(kind::kPallet, area);
    for (int i = count(2, 3); i > 0; --i) furnisher_.anywhere(kind::kTrolley, area);
    furnisher_.anywhere(kind::kStepladder, area);
    furnisher_.atWall(kind::kBarrels, hall_, true, 10);
    for (int i = count(2, 3); i > 0; --i) furnisher_.atWall(kind::kLocker, hall_);
    furnisher_.atWall(kind::kWorkbench, hall_);
    for (int i = count(4, 7); i > 0; --i) furnisher_.anywhere(kind::kCarton, area);
    for (int i = count(2, 4); i > 0; --i) furnisher_.atWall(kind::kBin, hall_, true, 15);
  }

  /** The west end and the sides of the aisles, where people leave things. */
  void furnishAisles() {
    const AlignedBox2d west(Vector2d(0, 0), Vector2d(racks_west_, hall_.max().y()));
    for (int i = count(1, 2); i > 0; --i) furnisher_.atWall(kind::kCupboard, west);
    for (int i = count(2, 4); i > 0; --i) furnisher_.anywhere(kind::kCarton, west);
    furnisher_.anywhere(kind::kPallet, west);
    const AlignedBox2d aisles(Vector2d(racks_west_, 1), Vector2d(racks_east_, hall_.max().y()));
    for (const Kind* kind :
         {&kind::kTrolley, &kind::kStepladder, &kind::kCarton, &kind::kCarton, &kind::kPallet})
      furnisher_.anywhere(*kind, aisles);
  }

  void furnishStoreRoom() {
    const AlignedBox2d room(store_.min() + Vector2d(kInnerWall / 2, 0),
                            store_.max() - Vector2d(0, kInnerWall / 2));
    for (int i = count(2, 3); i > 0; --i) furnisher_.atWall(kind::kBookcase, room);
    furnisher_.atWall(kind::kWorkbench, room);
    furnisher_.atWall(kind::kCupboard, room);
    furnisher_.atWall(kind::kLocker, room);
    furnisher_.atWall(kind::kBarrels, room, false, 20);
    furnisher_.anywhere(kind::kPallet, room);
    for (int i = count(2, 4); i > 0; --i) furnisher_.anywhere(kind::kCarton, room);
    plan_.take({Spot{room.center(), 0}, room.sizes().x(), room.sizes().y()});  // nothing else goes there
  }

  /** Notice boards, switch boxes, fire extinguishers and heaters on the walls. */
  void addFixtures() {
    for (int i = count(16, 22); i > 0; --i) {
      const double draw = random_.uniform();
      const double width = random_.uniform(0.4, 1.2), height = random_.uniform(0.4, 1.0);
      const double z = random_.uniform(0.7, 1.4);
      const auto spot = furnisher_.onWall(hall_, width, z);
      if (!spot) continue;
      if (draw < 0.35) {
        addPicture(builder_, *spot, width, height);
      } else if (draw < 0.75) {
        builder_.box(spot->relative(0.12, 0), {0.24, 0.7 * width, height});
      } else {
        builder_.cylinder(spot->relative(0.12, 0), 0.08, 0.5);
      }
    }
  }

  void addPeople() {
    for (const When when : {When::mapped, When::later})
      for (int i = count(2, 4); i > 0; --i) furnisher_.passing(kind::kPerson, hall_, when);
  }

  Eigen::AlignedBox2d hall_, store_;  // store_: between the lines of its walls
  double ceiling_ = 0;
  RackRow rack_;
  double racks_west_ = 0, racks_east_ = 0;             // x of their ends
  double aisle_1_ = 0, aisle_2_ = 0, aisle_3_ = 0;     // y of their middles
  std::vector<double> rows_;                           // y of the middles of the double rows
  double store_west_door_ = 0, store_north_door_ = 0;  // y and x
};

}  // namespace

SimulatedPlace hallFloor(std::uint64_t seed) { return HallFloor(seed).build(); }

}  // namespace facetloc
