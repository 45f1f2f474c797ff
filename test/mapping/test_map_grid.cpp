// SPDX-License-Identifier: BSD-3-Clause
#include "ranking/global_localization.h"

#include <facetloc/features/map_metadata.h>
#include <facetloc/features/pose.h>
#include <facetloc/mapping/floor_plan.h>
#include <facetloc/mapping/model_map.h>
#include <facetloc/segmentation/view_builder.h>
#include <facetloc/simulation/simulated_camera.h>
#include <facetloc/testing/matchers.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

namespace facetloc {
namespace {

using Eigen::Vector2d, Eigen::Vector3d, testing::HasSubstr;

constexpr double kWidth = 5, kDepth = 4,
                 kHeight = 2.6;  // height of a room with a cupboard and a beam under its ceiling
constexpr double kEye = 1;

void addBoxAt(SimulatedWorld& scene, const Vector3d& low, const Vector3d& high, std::uint16_t& next_id) {
  const Eigen::Isometry3d T(Eigen::Translation3d((low + high) / 2));
  addBox(scene, T, (high - low) / 2, next_id);
}

SimulatedWorld room() {
  SimulatedWorld scene;
  std::uint16_t next_id = 1;
  addBoxAt(scene, {0, 0, 0}, {kWidth, kDepth, kHeight}, next_id);
  addBoxAt(scene, {3.4, 0.02, 0}, {4.4, 0.62, 2}, next_id);
  addBoxAt(scene, {1, 0.02, 2.2}, {1.3, 3.98, 2.58}, next_id);  // above the band
  return scene;
}

Camera cameraOnWheels() {
  Camera camera;
  camera.intrinsics = {160, 120, 146, 146, 79.5, 59.5};
  camera.mounting = CameraMounting{kEye, 5};
  return camera;
}

/** Views from the middle of the room all around it. */
Map roundLook(bool mounting_is_known) {
  const Camera camera = cameraOnWheels();
  const SimulatedCamera simulated(camera.intrinsics, {}, 3);
  ViewBuilder builder(camera);
  Map map;
  map.camera = camera;
  if (!mounting_is_known) map.camera.mounting.reset();
  for (int i = 0; i < 24; ++i) {
    const Eigen::Isometry3d T_w_b = Eigen::Translation3d(2 + 0.5 * (i % 2), 2, 0) *
                                    Eigen::AngleAxisd(i * 15 * kDegree, Vector3d::UnitZ());
    const Eigen::Isometry3d T_w_c = T_w_b * camera.mounting->T_b_c();
    map.models.emplace_back(std::to_string(i), i, T_w_c,
                            builder.build(simulated.render(room(), T_w_c, i).depth));
  }
  return map;
}

enum class Truth { wall, inside, outside };

/** Truth by the plan of the room alone; near a wall it may be either. */
Truth truthAt(const Eigen::Vector2d& p) {
  constexpr double kNear = 0.08;
  const auto distanceTo = [&p](const Eigen::AlignedBox2d& box) {
    const double outside = box.exteriorDistance(p);
    const Eigen::Vector2d in = (p - box.min()).cwiseMin(box.max() - p);
    return outside > 0 ? outside : -in.minCoeff();
  };
  const double of_room = distanceTo({Eigen::Vector2d(0, 0), Eigen::Vector2d(kWidth, kDepth)});
  const double of_cupboard = distanceTo({Eigen::Vector2d(3.4, 0.02), Eigen::Vector2d(4.4, 0.62)});
  if (std::abs(of_room) < kNear || std::abs(of_cupboard) < kNear) return Truth::wall;
  return of_room < 0 && of_cupboard > 0 ? Truth::inside : Truth::outside;
}

TEST(MapGrid, IsThePlanOfTheRoom) {
  for (const bool mounting_is_known : {true, false}) {
    const OccupancyGrid grid = gridOf(roundLook(mounting_is_known));
    int occupied = 0, free = 0;
    for (int row = 0; row < grid.height; ++row)
      for (int column = 0; column < grid.width; ++column) {
        const Truth truth = truthAt(grid.centre(column, row));
        if (grid.isOccupied(column, row)) ++occupied;
        if (grid.isFree(column, row)) ++free;
        EXPECT_FALSE(grid.isOccupied(column, row) && truth != Truth::wall)
            << grid.centre(column, row).transpose();
        EXPECT_FALSE(grid.isFree(column, row) && truth == Truth::outside)
            << grid.centre(column, row).transpose();
      }
    // Most of 18 m of walls in cells of 5 cm, and of 19.4 m2 of floor, are seen.
    EXPECT_GT(occupied, 240);
    EXPECT_GT(free * 0.0025, 17);
  }
}

TEST(MapGrid, ResolutionAndBandAreChosen) {
  MapGridParams params;
  params.resolution = 0.1, params.highest = 2.4;  // with the beam
  const OccupancyGrid grid = gridOf(roundLook(true), params);
  EXPECT_EQ(grid.resolution, 0.1);
  const auto isOccupiedNear = [&grid](const Eigen::Vector2d& p) {
    const Eigen::Vector2d cell = grid.cellOf(p);
    bool occupied = false;
    for (int i = 0; i < 9; ++i)
      occupied |= grid.isOccupied(static_cast<int>(std::floor(cell.x())) + i % 3 - 1,
                                  static_cast<int>(std::floor(cell.y())) + i / 3 - 1);
    return occupied;
  };
  EXPECT_TRUE(isOccupiedNear({5, 3}));
  params.resolution = 1, params.lowest = 2, params.highest = 2;
  EXPECT_THROW(gridOf(roundLook(true), params), std::invalid_argument);
}

TEST(MapGrid, NamesTheCauseOfFailure) {
  const auto errorOf = [](const Map& map) {
    return test::messageOf<std::runtime_error>([&] { gridOf(map); });
  };
  EXPECT_THAT(errorOf({}), HasSubstr("pose"));
  Map far = roundLook(true);
  far.models[0].T_w_m->translation().x() = 1e8;
  EXPECT_THAT(errorOf(far), HasSubstr("coarser"));
  Map in_the_air = roundLook(false);
  for (LocalModel& model : in_the_air.models) {
    View view = *in_the_air.view(0);
    view.segments.clear();
    model.setView(view);
  }
  EXPECT_THAT(errorOf(in_the_air), HasSubstr("floor"));
}

constexpr double kThick = 0.2;  // thickness of a wall

/** A wall of a building: an upright box on the floor. */
struct Wall {
  Vector2d low, high;
};

/** A room with a niche and a wing, without equal sides. */
const std::vector<Wall>& walls() {
  static const std::vector<Wall> all = {{{-kThick, -kThick}, {6 + kThick, 0}},
                                        {{6, 0}, {6 + kThick, 3}},
                                        {{4.2, 3}, {6 + kThick, 3 + kThick}},
                                        {{4.2, 3 + kThick}, {4.4, 5}},
                                        {{-kThick, 5}, {4.4, 5.2}},
                                        {{-kThick, 3.1}, {0, 5}},
                                        {{-kThick, 0}, {0, 2}},
                                        {{-0.8, 1.8}, {-kThick, 2}},
                                        {{-0.8, 3.1}, {-kThick, 3.3}},
                                        {{-1, 1.8}, {-0.8, 3.3}},
                                        {{2.2, 4.2}, {2.5, 5}}};
  return all;
}

/** The building with things that no plan shows: cupboards before its walls, a table, a shelf. */
SimulatedWorld furnished() {
  SimulatedWorld scene;
  std::uint16_t next_id = 1;
  addBoxAt(scene, {-2, -1, -0.2}, {8, 7, 0}, next_id);
  addBoxAt(scene, {-2, -1, kHeight}, {8, 7, kHeight + 0.2}, next_id);
  for (const Wall& w : walls())
    addBoxAt(scene, {w.low.x(), w.low.y(), 0}, {w.high.x(), w.high.y(), kHeight}, next_id);
  addBoxAt(scene, {1, 0.01, 0}, {2.2, 0.46, 1.9}, next_id);
  addBoxAt(scene, {5.4, 1.2, 0}, {5.99, 2.3, 0.8}, next_id);
  addBoxAt(scene, {0.02, 3.6, 0}, {0.4, 4.6, 1.4}, next_id);
  addBoxAt(scene, {3.2, 4.5, 0.3}, {4.1, 4.98, 1.2}, next_id);
  return scene;
}

OccupancyGrid plan() {
  OccupancyGrid grid = OccupancyGrid::filled(180, 150, 0.05, {-1.52, -0.72}, OccupancyGrid::kUnknown);
  for (int row = 0; row < grid.height; ++row)
    for (int column = 0; column < grid.width; ++column) {
      const Vector2d p = grid.centre(column, row);
      std::int8_t& cell = grid.cells[grid.index(column, row)];
      if (p.x() > -0.9 && p.x() < 6.1 && p.y() > 0 && p.y() < 5.1) cell = OccupancyGrid::kFree;
      for (const Wall& w : walls())
        if (Eigen::AlignedBox2d(w.low, w.high).contains(p)) cell = OccupancyGrid::kOccupied;
    }
  return grid;
}

/** A camera among furniture that its map, a floor plan, lacks. */
TEST(PlanLocalization, FurnitureThatThePlanLacksDoesNotObject) {
  Camera camera;
  camera.intrinsics = {320, 240, 290, 290, 159.5, 119.5};
  camera.mounting = CameraMounting{1, 10};
  FloorPlanParams params;
  params.wall_height = kHeight;
  ModelMap making(std::make_shared<FloorPlanSurface>(plan(), params), camera);
  making.setWorkingWidth(160);
  const auto map = std::make_shared<const Map>(making.finish());
  ASSERT_GT(map->models.size(), 10u) << making.findings().problem;
  EXPECT_TRUE(lacksSurfaces(*map));

  internal::GlobalLocalization localization(map);
  const SimulatedCamera simulated(camera.intrinsics, {}, 3);
  ViewBuilder builder(camera);
  const SimulatedWorld scene = furnished();
  int right = 0, sure = 0, asked = 0;
  for (const Vector2d& place : {Vector2d(1.5, 2.5), Vector2d(3, 2), Vector2d(4.6, 1.6), Vector2d(2.6, 3.2)})
    for (int heading = 20; heading < 360; heading += 60) {
      const Eigen::Isometry3d T_w_b = Eigen::Translation3d(place.x(), place.y(), 0) *
                                      Eigen::AngleAxisd(heading * kDegree, Vector3d::UnitZ());
      const Eigen::Isometry3d truth = T_w_b * camera.mounting->T_b_c();
      const Localization answer =
          localization.localize(builder.build(simulated.render(scene, truth, ++asked).depth));
      const bool is_right =
          !answer.hypotheses.empty() && isNear(*answer.hypotheses.front().T_w_c, truth, 0.3, 5);
      right += is_right;
      if (answer.state != AnswerState::sure) continue;
      ++sure;
      EXPECT_TRUE(is_right) << "sure and wrong at " << place.transpose() << ", " << heading << " deg";
    }
  EXPECT_GE(right, 0.6 * asked) << sure << " of " << asked << " sure";
}

}  // namespace
}  // namespace facetloc
