// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/pose.h>
#include <facetloc/mapping/floor_plan.h>
#include <facetloc/segmentation/view_builder.h>
#include <facetloc/simulation/simulated_camera.h>
#include <facetloc/testing/matchers.h>

#include <gmock/gmock.h>

#include <cmath>

namespace facetloc {
namespace {

using Eigen::Vector3d, testing::HasSubstr;

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

}  // namespace
}  // namespace facetloc
