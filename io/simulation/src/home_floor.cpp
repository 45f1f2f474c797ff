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

// Middle of a bedroom's door to the line of the wall beside it [m].
constexpr double kDoorFromCorner = 0.85;

// Lengths in metres.
constexpr double kOuterWall = 0.32;  // thickness
constexpr double kDoorWidth = 1.0, kDoorHeight = 2.05, kLeafHeight = 2.03;
constexpr double kWindowTop = 2.2;

/** \brief A flat: living room and kitchen in the west, a hallway from there to the entrance in the east;
 * south of it two bedrooms, equal on purpose, north of it a study between the kitchen and the bath. The
 * study, which has doors to the hallway and to the kitchen, is shut when the map is made. Half of the flats
 * are mirrored.
 *
 *     +---------+--------+------+
 *     | kitchen | study  | bath |
 *     |         +--------+------+
 *     +--   --+   hallway       |
 *     | living  +-------+-------+
 *     | room    | bed A | bed B |
 *     +---------+-------+-------+
 */
class HomeFloor : FurnishedFloor {
public:
  explicit HomeFloor(std::uint64_t seed) : FurnishedFloor(seed, kFurniture) {}

  SimulatedPlace build() {
    drawSizes();
    drawRoutes();
    buildOuterWalls();
    buildInnerWalls();
    buildDoors();
    addShaft({0, kitchen_ - kWall / 2}, {1, -1});
    addShaft({width_, depth_}, {-1, -1});
    furnishLivingRoom();
    furnishKitchen();
    furnishBedrooms();
    furnishBath();
    furnishHallway();
    furnishStudy();
    addRadiators();
    addPeople();
    place_.unmapped_rooms = {study_};
    if (mirrored_) mirror(place_, width_);
    return std::move(place_);
  }

private:
  enum Purpose : std::uint64_t { kSizes, kWays, kFurniture };

  // Lengths in metres.
  static constexpr double kCeiling = 2.5;
  static constexpr double kWall = 0.12;  // thickness of the inner walls
  static constexpr double kHallwayWidth = 2.0;

  // ---- Sizes and ways ----
  void drawSizes() {
    Random random(derivedSeed(seed_, kSizes));
    width_ = random.uniform(11.4, 12.0);
    depth_ = random.uniform(9.3, 9.8);
    west_ = random.uniform(4.7, 5.1);
    south_ = random.uniform(3.7, 3.95);
    north_ = south_ + kHallwayWidth;
    between_bedrooms_ = (west_ + width_ + kWall / 2) / 2;
    kitchen_ = north_ + random.uniform(-0.3, 0.1);
    door_a_ = west_ + kDoorFromCorner;
    door_b_ = between_bedrooms_ + kDoorFromCorner;
    bath_ = door_b_ - random.uniform(1.0, 1.2);
    study_door_ = random.uniform(west_ + 1.5, bath_ - 1.2);
    pantry_door_ = north_ + random.uniform(1.25, 1.6);
    kitchen_opening_ = random.uniform(1.5, 2.0);
    mirrored_ = random.uniform() < 0.5;
    const double half = kWall / 2;
    living_room_ = {Vector2d(0, 0), Vector2d(west_ - half, kitchen_ - half)};
    kitchen_room_ = {Vector2d(0, kitchen_ + half), Vector2d(west_ - half, depth_)};
    hallway_ = {Vector2d(west_ + half, south_ + half), Vector2d(width_, north_ - half)};
    bedroom_a_ = {Vector2d(west_ + half, 0), Vector2d(between_bedrooms_ - half, south_ - half)};
    bedroom_b_ = {Vector2d(between_bedrooms_ + half, 0), Vector2d(width_, south_ - half)};
    study_ = {Vector2d(west_ + half, north_ + half), Vector2d(bath_ - half, depth_)};
    bath_room_ = {Vector2d(bath_ + half, north_ + half), Vector2d(width_, depth_)};
  }

  /** The robot goes through doors near their middle; elsewhere the two ways are apart. */
  void drawRoutes() {
    Random random(derivedSeed(seed_, kWays));
    const auto within = [&](double spread, double x, double y) {
      const double dx = random.uniform(-spread, spread), dy = random.uniform(-spread, spread);
      return Waypoint{{x + dx, y + dy}, 0};
    };
    const auto near = [&](double x, double y) { return within(0.12, x, y); };
    const auto in_door = [&](double x, double y) { return within(0.04, x, y); };
    const double middle = (south_ + north_) / 2;
    const double lane = middle - random.uniform(0.02, 0.08);
    const double south_door = south_ - 0.55, north_door = north_ + 0.55;

    Route& mapping = place_.mapping_route;
    mapping = {near(west_ - 1.2, lane),
               near(2.9, middle - 0.9),
               near(2.3, 2.2),
               near(kitchen_opening_ - 0.1, kitchen_ - 0.8),
               near(kitchen_opening_ - 0.1, kitchen_ + 0.8),
               near(2.9, kitchen_ + 1.6),
               near(kitchen_opening_ + 0.1, kitchen_ + 0.7),
               near(kitchen_opening_ + 0.1, kitchen_ - 0.7),
               near(west_ - 0.9, lane),
               {{door_a_, lane}, 0},
               in_door(door_a_, south_door),
               near(door_a_ + 0.6, south_ - 1.5),
               in_door(door_a_, south_door),
               {{door_a_, lane}, 0},
               {{door_b_, lane}, 0},
               in_door(door_b_, south_door),
               near(door_b_ + 0.6, south_ - 1.5),
               in_door(door_b_, south_door),
               in_door(door_b_, north_door),
               near(door_b_ + 0.2, north_ + 1.3),
               in_door(door_b_, north_door),
               {{door_b_, lane}, 0},
               {{west_, lane}, 0}};

    const double other_lane = lane + random.uniform(0.2, 0.28);
    Route& query = place_.query_route;
    query = {{{width_ - 1.0, other_lane}, 0},
             {{study_door_, other_lane}, 0},
             in_door(study_door_, north_door),
             in_door(west_ + 0.6, pantry_door_),
             in_door(west_ - 0.6, pantry_door_),
             near(kitchen_opening_ + 0.35, kitchen_ + 1.5),
             near(kitchen_opening_ + 0.1, kitchen_ - 0.6),
             near(1.7, 2.6),
             near(3.1, 2.4),
             near(west_ - 0.8, other_lane),
             {{door_a_, other_lane}, 0},
             in_door(door_a_, south_door),
             near(door_a_ + 0.25, south_ - 1.6),
             in_door(door_a_, south_door),
             {{door_a_, other_lane}, 0},
             {{door_b_, other_lane}, 0},
             in_door(door_b_, south_door),
             near(door_b_ + 0.25, south_ - 1.6),
             in_door(door_b_, south_door),
             {{door_b_, other_lane}, 0}};
    plan_.keepFree(mapping);
    plan_.keepFree(query);
  }

  // ---- Walls, windows and doors ----
  /** A window's bar and its curtains. */
  void dressWindow(const Spot& inside, const Opening& opening) {
    constexpr double kReach = 0.3;  // reach of things that must not hide a window
    plan_.take({inside.relative(kReach / 2, 0), kReach, opening.width},
               opening.bottom > 0 ? kHigh : kAllHeights);
    const Spot bar = inside.relative(-kOuterWall / 2, 0, 0, opening.bottom);
    builder_.box(bar, {0.06, 0.08, opening.top - opening.bottom});
    if (opening.bottom > 0) windows_.push_back(inside);
    const double curtain = random_.uniform();
    if (curtain < 0.4) return;
    constexpr double kCurtainWidth = 0.3;
    const double bottom = opening.bottom > 0 ? opening.bottom - 0.1 : 0.03;
    for (const int side : {-1, 1})
      addCurtain(builder_, inside.relative(0, side * opening.width / 2, 0, bottom), kCurtainWidth,
                 kWindowTop + 0.1 - bottom, random_);
  }

  Opening drawWindow(double at) {
    const double width = random_.uniform(1.1, 1.7);
    const double bottom = random_.uniform(0.8, 0.95);
    return {at, width, bottom, kWindowTop, true};
  }

  /** The wall around the flat. Its line runs in its middle; windows are given by their place inside. */
  void buildOuterWalls() {
    const double out = kOuterWall / 2;
    const double right = width_ + out, top = depth_ + out;
    const auto wall = [&](const Vector2d& from, const Vector2d& to, const std::vector<Opening>& openings) {
      // Outside to the right of the way from its start to its end.
      const Vector2d along = (to - from).normalized();
      const double yaw = std::atan2(along.x(), -along.y());
      for (const Opening& opening : openings) {
        if (!opening.glazed) continue;
        dressWindow(Spot{from + opening.at * along, yaw}.relative(out, 0), opening);
      }
      builder_.wall(from, to, kOuterWall, kCeiling, openings);
    };
    Opening balcony = drawWindow(out + 0.42 * west_);
    balcony.bottom = 0;
    const double bedroom = 0.56 * bedroom_a_.sizes().x();
    Opening window_a = drawWindow(out + bedroom_a_.min().x() + bedroom);
    Opening window_b = window_a;
    window_b.at += bedroom_b_.min().x() - bedroom_a_.min().x();
    wall({-out, -out}, {right, -out}, {balcony, window_a, window_b});
    constexpr double kEntranceWidth = 0.95;
    const Opening entrance{out + (south_ + north_) / 2, kEntranceWidth};
    wall({right, -out}, {right, top}, {entrance});
    builder_.doorLeaf({width_ + 0.05, (south_ + north_ - kEntranceWidth) / 2}, kPi / 2, kEntranceWidth,
                      kDoorHeight);
    Opening bath_window = drawWindow(right - bath_room_.center().x());
    bath_window.width = 0.7;
    bath_window.bottom = 1.3;
    const Opening study_window = drawWindow(right - study_.center().x());
    wall({right, top}, {-out, top}, {bath_window, study_window});
    const Opening kitchen_window = drawWindow(top - kitchen_room_.center().y());
    const Opening living_window = drawWindow(top - 0.55 * living_room_.sizes().y());
    wall({-out, top}, {-out, -out}, {kitchen_window, living_window});
    const AlignedBox2d all(Vector2d(-out, -out), Vector2d(right, top));
    builder_.level(all, 0);
    builder_.level(all, kCeiling);
  }

  void buildInnerWalls() {
    const auto door = [](double at) { return Opening{at, kDoorWidth, 0, kDoorHeight}; };
    const double middle = (south_ + north_) / 2;
    builder_.wall({west_, 0}, {west_, depth_}, kWall, kCeiling,
                  {{middle, kHallwayWidth - 0.5, 0, 2.15}, door(pantry_door_)});
    constexpr double kPassage = 1.7;
    builder_.wall({0, kitchen_}, {west_, kitchen_}, kWall, kCeiling, {{kitchen_opening_, kPassage, 0, 2.2}});
    builder_.wall({west_, south_}, {width_, south_}, kWall, kCeiling,
                  {door(door_a_ - west_), door(door_b_ - west_)});
    builder_.wall({west_, north_}, {width_, north_}, kWall, kCeiling,
                  {door(study_door_ - west_), door(door_b_ - west_)});
    builder_.wall({between_bedrooms_, 0}, {between_bedrooms_, south_}, kWall, kCeiling);
    builder_.wall({bath_, north_}, {bath_, depth_}, kWall, kCeiling);
  }

  /** A leaf that stands open into a room: closed it would lie along a direction, opening turns it to one
   * side. */
  void openLeaf(const Vector2d& hinge, double closed, int sense, double most) {
    constexpr double kLeast = 89 * kDegree;
    const double leaf = kDoorWidth - 0.02;
    const double mapped = random_.uniform(kLeast, most), later = random_.uniform(kLeast, most);
    if (random_.uniform() < 0.4) {
      builder_.doorLeaf(hinge, closed + sense * mapped, leaf, kLeafHeight);
    } else {
      builder_.doorLeaf(hinge, closed + sense * mapped, leaf, kLeafHeight, When::mapped);
      builder_.doorLeaf(hinge, closed + sense * later, leaf, kLeafHeight, When::later);
    }
    takeLeaf(hinge, closed, sense);
  }

  /** A leaf that is shut when the map is made. */
  void shutLeaf(const Vector2d& hinge, double closed, int sense) {
    const double leaf = kDoorWidth - 0.02;
    const double later = random_.uniform(91 * kDegree, 105 * kDegree);
    builder_.doorLeaf(hinge, closed, leaf, kLeafHeight, When::mapped);
    builder_.doorLeaf(hinge, closed + sense * later, leaf, kLeafHeight, When::later);
    takeLeaf(hinge, closed, sense);
  }

  void takeLeaf(const Vector2d& hinge, double closed, int sense) {
    const Spot open{hinge, closed + sense * kPi / 2};
    constexpr double kSwing = 0.4;
    plan_.take({open.relative(kDoorWidth / 2, sense * kSwing / 2), kDoorWidth, kSwing});
  }

  void buildDoors() {
    const double half = kDoorWidth / 2, face = kWall / 2;
    constexpr double kUpToWall = 100 * kDegree, kWide = 125 * kDegree;
    openLeaf({door_a_ - half, south_ - face}, 0, -1, kUpToWall);
    openLeaf({door_b_ - half, south_ - face}, 0, -1, kUpToWall);
    openLeaf({door_b_ + half, north_ + face}, kPi, -1, kWide);
    shutLeaf({study_door_ + half, north_ + 0.03}, kPi, -1);
    shutLeaf({west_ + 0.03, pantry_door_ + half}, -kPi / 2, 1);
    addFrames();
    // Nothing on the walls at the openings.
    const auto keep = [&](double x, double y, double depth, double width) {
      plan_.take({Spot{{x, y}, 0}, depth, width});
    };
    keep(west_, pantry_door_, 0.5, kDoorWidth);
    keep(west_, (south_ + north_) / 2, 0.5, kHallwayWidth - 0.5);
    keep(kitchen_opening_, kitchen_, 1.7, 0.5);
    for (const double x : {door_a_, door_b_}) keep(x, south_, kDoorWidth, 0.5);
    for (const double x : {study_door_, door_b_}) keep(x, north_, kDoorWidth, 0.5);
    keep(width_, (south_ + north_) / 2, 0.3, kDoorWidth);
  }

  void addFrames() {
    const double face = kWall / 2;
    const auto frames = [&](const Vector2d& door, double yaw) {
      for (const double turn : {0.0, kPi})
        addDoorFrame(builder_, Spot{door, yaw + turn}.relative(face, 0), kDoorWidth, kDoorHeight);
    };
    frames({door_a_, south_}, kPi / 2);
    frames({door_b_, south_}, kPi / 2);
    frames({door_b_, north_}, kPi / 2);
    frames({study_door_, north_}, kPi / 2);
    frames({west_, pantry_door_}, 0);
  }

  /** A chimney or a shaft for pipes in a corner of a room. */
  void addShaft(const Vector2d& corner, const Vector2d& inward) {
    const double x = random_.uniform(0.35, 0.6), y = random_.uniform(0.3, 0.5);
    const Spot spot{corner + Vector2d(inward.x() * x / 2, inward.y() * y / 2), 0};
    builder_.pillar(spot, {x, y, kCeiling});
    plan_.take({spot, x, y});
  }

  // ---- Furniture ----
  void addPictures(const AlignedBox2d& room, int number) {
    for (int i = 0; i < number; ++i) {
      const double width = random_.uniform(0.3, 1.1), height = random_.uniform(0.3, 0.75);
      const double z = random_.uniform(1.15, 1.6);
      const bool shelf = random_.uniform() < 0.3;
      if (const auto spot = furnisher_.onWall(room, width, z)) {
        if (shelf) {
          addWallShelf(builder_, *spot, width, random_);
        } else {
          addPicture(builder_, *spot, width, height);
        }
      }
    }
  }

  /** Chairs at two sides of a table or in front of a desk; they look at it. */
  void addChairs(const Kind& kind, const Spot& table, const AlignedBox2d& room, int number, bool both_sides) {
    constexpr double kOff = 0.34;  // middle of a chair to the edge of the table
    for (int i = 0; i < number; ++i) {
      const int side = both_sides && i % 2 ? -1 : 1;
      const int in_row = both_sides ? i / 2 : i;
      const double y = (in_row ? 0.36 : -0.36) * (both_sides ? 1 : 0);
      const Spot spot = table.relative(side * (kind.depth / 2 + kOff), y, side > 0 ? kPi : 0);
      furnisher_.at(kind::kChair, spot, room, true, 0.03, 25);
    }
  }

  void addDiningTable(const AlignedBox2d& room) {
    const bool round = random_.uniform() < 0.35;
    const Kind& kind = round ? kind::kRoundTable : kind::kTable;
    constexpr double kAtWall = 0.5;  // some tables stand with one side at the wall
    const auto table =
        random_.uniform() < kAtWall ? furnisher_.atWall(kind, room) : furnisher_.anywhere(kind, room, false);
    if (!table) return;
    addChairs(kind, *table, room, count(2, 4), true);
    if (random_.uniform() < 0.6) addPendantLamp(builder_, *table, kCeiling, random_);
  }

  void addSmallThings(const AlignedBox2d& room, int number) {
    for (int i = 0; i < number; ++i) {
      const double draw = random_.uniform();
      const Kind& kind = draw < 0.35   ? kind::kPlant
                         : draw < 0.55 ? kind::kLamp
                         : draw < 0.75 ? kind::kBin
                                       : kind::kCarton;
      furnisher_.atWall(kind, room, true, 20);
    }
  }

  void furnishLivingRoom() {
    const AlignedBox2d& room = living_room_;
    const auto sofa = furnisher_.atWall(kind::kSofa, room, false, 6);
    if (sofa) {
      constexpr double kFar = 0.85;  // distance between the middles of the sofa and the table before it
      furnisher_.at(kind::kCoffeeTable, sofa->relative(kFar + 0.1, 0), room, true, 0.1, 15);
    }
    furnisher_.atWall(kind::kTvStand, room);
    furnisher_.atWall(kind::kBookcase, room);
    addDiningTable(room);
    furnisher_.atWall(random_.uniform() < 0.5 ? kind::kSideboard : kind::kCupboard, room);
    for (int i = count(1, 2); i > 0; --i) furnisher_.anywhere(kind::kArmchair, room);
    furnisher_.atWall(kind::kBookcase, room);
    addSmallThings(room, count(3, 5));
    addPictures(room, count(3, 5));
  }

  void furnishKitchen() {
    const AlignedBox2d& room = kitchen_room_;
    // The unit stands in the middle of the north wall or in one of its corners.
    const double slack = (room.sizes().x() - kind::kKitchenUnit.width) / 2 - kind::kFridge.width - 0.05;
    const double x = room.center().x() + random_.uniform(-slack, slack);
    const Spot unit{{x, room.max().y() - kind::kKitchenUnit.depth / 2 - 0.005}, -kPi / 2};
    if (furnisher_.at(kind::kKitchenUnit, unit, room)) {
      const int first = random_.uniform() < 0.5 ? 1 : -1;
      const double beside = (kind::kKitchenUnit.width + kind::kFridge.width + 0.03) / 2;
      for (const int side : {first, -first})
        if (furnisher_.at(kind::kFridge, unit.relative(0, side * beside), room)) break;
    }
    addDiningTable(room);
    furnisher_.atWall(kind::kCupboard, room);
    furnisher_.atWall(kind::kSideboard, room);
    addSmallThings(room, count(2, 4));
    addPictures(room, count(2, 4));
  }

  /** Both bedrooms have the same pieces, each placed by hand. */
  void furnishBedrooms() {
    for (const AlignedBox2d& room : {bedroom_a_, bedroom_b_}) {
      const auto bed = furnisher_.atWall(kind::kBed, room);
      furnisher_.atWall(kind::kWardrobe, room);
      if (bed) {
        const double x = -(kind::kBed.depth - kind::kBedsideTable.depth) / 2;
        const double y = (kind::kBed.width + kind::kBedsideTable.width) / 2 + 0.03;
        for (const int side : {-1, 1}) furnisher_.at(kind::kBedsideTable, bed->relative(x, side * y), room);
      }
    }
    for (const AlignedBox2d& room : {bedroom_a_, bedroom_b_}) {
      const bool works = random_.uniform() < 0.6;
      const Kind& kind = works ? kind::kDesk : kind::kSideboard;
      if (const auto desk = furnisher_.atWall(kind, room); desk && works)
        addChairs(kind::kDesk, *desk, room, 1, false);
      furnisher_.atWall(kind::kBookcase, room);
      addSmallThings(room, count(2, 4));
      addPictures(room, count(2, 4));
    }
  }

  void furnishBath() {
    const AlignedBox2d& room = bath_room_;
    for (const Kind* kind :
         {&kind::kBathtub, &kind::kWashbasin, &kind::kToilet, &kind::kWashingMachine, &kind::kShoeCupboard})
      furnisher_.atWall(*kind, room);
    furnisher_.atWall(kind::kBin, room, true);
    addPictures(room, count(1, 2));
  }

  void furnishHallway() {
    for (const Kind* kind : {&kind::kShoeCupboard, &kind::kRadiator, &kind::kCoats, &kind::kRadiator})
      furnisher_.atWall(*kind, hallway_);
    if (random_.uniform() < 0.5) furnisher_.atWall(kind::kShoeCupboard, hallway_);
    furnisher_.atWall(kind::kBin, hallway_, true, 20);
    addPictures(hallway_, count(3, 5));
  }

  void furnishStudy() {
    const AlignedBox2d& room = study_;
    if (const auto desk = furnisher_.atWall(kind::kDesk, room)) addChairs(kind::kDesk, *desk, room, 1, false);
    furnisher_.atWall(kind::kBookcase, room);
    furnisher_.atWall(kind::kCupboard, room);
    furnisher_.atWall(kind::kBookcase, room);
    furnisher_.anywhere(kind::kArmchair, room);
    addSmallThings(room, count(2, 3));
    addPictures(room, count(2, 3));
  }

  /** Radiators below windows where nothing else stands. */
  void addRadiators() {
    const double reach = kind::kRadiator.width;
    for (const Spot& window : windows_) {
      const Spot spot = window.relative(kind::kRadiator.depth / 2 + 0.001, 0);
      const AlignedBox2d around(spot.place - Vector2d(reach, reach), spot.place + Vector2d(reach, reach));
      furnisher_.at(kind::kRadiator, spot, around);
    }
  }

  void addPeople() {
    const std::pair<const AlignedBox2d*, When> people[] = {{&living_room_, When::mapped},
                                                           {&kitchen_room_, When::mapped},
                                                           {&living_room_, When::later},
                                                           {&kitchen_room_, When::later},
                                                           {&bedroom_b_, When::later}};
    for (const auto& [room, when] : people) {
      const bool there = random_.uniform() < 0.6;
      if (there) furnisher_.passing(kind::kPerson, *room, when);
    }
  }

  double width_ = 0, depth_ = 0;             // inside of the outer walls
  double west_ = 0;                          // x of the wall between the west rooms and the others
  double south_ = 0, north_ = 0;             // y of the hallway's walls
  double kitchen_ = 0;                       // y of the wall between the living room and the kitchen
  double between_bedrooms_ = 0, bath_ = 0;   // x of the walls there
  double door_a_ = 0, door_b_ = 0;           // x of the bedrooms' doors; the bath's is opposite the second
  double study_door_ = 0, pantry_door_ = 0;  // x of the one to the hallway, y of the one to the kitchen
  double kitchen_opening_ = 0;               // x
  std::vector<Spot> windows_;                // on the inner face, at the floor
  Eigen::AlignedBox2d living_room_, kitchen_room_, hallway_, bedroom_a_, bedroom_b_, study_, bath_room_;
};

}  // namespace

SimulatedPlace homeFloor(std::uint64_t seed) { return HomeFloor(seed).build(); }

}  // namespace facetloc
