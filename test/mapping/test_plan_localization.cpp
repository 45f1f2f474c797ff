// SPDX-License-Identifier: BSD-3-Clause
#include "ranking/global_localization.h"

#include <facetloc/features/map_metadata.h>
#include <facetloc/features/pose.h>
#include <facetloc/mapping/floor_plan.h>
#include <facetloc/mapping/model_map.h>
#include <facetloc/segmentation/view_builder.h>
#include <facetloc/simulation/simulated_camera.h>

#include <gtest/gtest.h>

#include <memory>

namespace facetloc {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

constexpr double kHeight = 2.6, kThick = 0.2;

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

void addBoxAt(SimulatedWorld& scene, const Vector3d& low, const Vector3d& high, std::uint16_t& next_id) {
  const Eigen::Isometry3d T(Eigen::Translation3d((low + high) / 2));
  addBox(scene, T, (high - low) / 2, next_id);
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

Camera cameraOnWheels() {
  Camera camera;
  camera.intrinsics = {320, 240, 290, 290, 159.5, 119.5};
  camera.mounting = CameraMounting{1, 10};
  return camera;
}

/** A camera among furniture that its map, a floor plan, lacks. */
TEST(PlanLocalization, FurnitureThatThePlanLacksDoesNotObject) {
  const Camera camera = cameraOnWheels();
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
