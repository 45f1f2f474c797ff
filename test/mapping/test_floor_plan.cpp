// SPDX-License-Identifier: BSD-3-Clause
#include "models/plan_outlines.h"

#include <facetloc/features/pose.h>
#include <facetloc/mapping/floor_plan.h>
#include <facetloc/mapping/mesh_surface.h>
#include <facetloc/mapping/model_map.h>

#include <gmock/gmock.h>

#include <cmath>
#include <random>

namespace facetloc {
namespace {

using Eigen::Vector2d, Eigen::Vector2i;

/** A wall as it is drawn: a rectangle about a middle [m], turned. */
struct DrawnWall {
  Vector2d middle;
  double length, width, yaw;

  Vector2d own(const Vector2d& p) const { return Eigen::Rotation2Dd(-yaw) * (p - middle); }
  bool contains(const Vector2d& p) const {
    return std::abs(own(p).x()) <= length / 2 && std::abs(own(p).y()) <= width / 2;
  }
};

OccupancyGrid drawn(const std::vector<DrawnWall>& walls, int size, double resolution) {
  OccupancyGrid grid = OccupancyGrid::filled(size, size, resolution, {0, 0}, OccupancyGrid::kFree);
  for (int row = 0; row < size; ++row)
    for (int column = 0; column < size; ++column)
      for (const DrawnWall& wall : walls)
        if (wall.contains(grid.centre(column, row)))
          grid.cells[grid.index(column, row)] = OccupancyGrid::kOccupied;
  return grid;
}

TEST(FloorPlan, OutlinesHaveOccupiedCellsOnTheLeft) {
  OccupancyGrid grid = OccupancyGrid::filled(5, 4, 1, {0, 0}, OccupancyGrid::kFree);
  for (const auto& [column, row] :
       {std::pair<int, int>{1, 1}, {2, 1}, {3, 2}})  // the last two touch at a corner
    grid.cells[grid.index(column, row)] = OccupancyGrid::kOccupied;
  const auto outlines = internal::outlinesOf(grid);
  ASSERT_EQ(outlines.size(), 1u) << "cells that touch at a corner are one thing";
  double doubled = 0;
  for (std::size_t i = 0; i < outlines[0].size(); ++i) {
    const Vector2i &a = outlines[0][i], &b = outlines[0][(i + 1) % outlines[0].size()];
    EXPECT_EQ((b - a).cwiseAbs().sum(), 1);
    doubled += a.x() * b.y() - a.y() * b.x();
  }
  EXPECT_EQ(doubled / 2, 3) << "the area of three cells, counterclockwise";
  // A ring has two outlines.
  OccupancyGrid ring = OccupancyGrid::filled(5, 5, 1, {0, 0}, OccupancyGrid::kOccupied);
  ring.cells[ring.index(2, 2)] = OccupancyGrid::kFree;
  EXPECT_EQ(internal::outlinesOf(ring).size(), 2u);
}

TEST(FloorPlan, ARectangleOfCellsHasFourSides) {
  const internal::CellOutline outline =
      internal::outlinesOf(drawn({{{1.5, 1.5}, 2, 0.2, 0}}, 60, 0.05)).at(0);
  const internal::StraightOutline corners = internal::straightened(outline);
  ASSERT_EQ(corners.size(), 4u);
  for (const Vector2d& corner : corners) {
    EXPECT_NEAR(std::abs(corner.x() - 30), 20, 1e-9);
    EXPECT_NEAR(std::abs(corner.y() - 30), 2, 1e-9);
  }
}

/** Walls in any direction: sides as long as walls lie on them, in their directions. */
TEST(FloorPlan, SidesAreWallsAndNotStairs) {
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> angle(-90, 90), size(1.5, 4.5), thick(0.15, 0.4), off(-0.05, 0.05);
  constexpr double kCell = 0.05;
  double turned = 0;  // change of the directions, over the length of a wall [cells]
  int sides = 0;
  for (int i = 0; i < 200; ++i) {
    const DrawnWall wall{
        {3 + off(engine), 3 + off(engine)}, size(engine), thick(engine), angle(engine) * kDegree};
    const auto outlines = internal::outlinesOf(drawn({wall}, 120, kCell));
    ASSERT_EQ(outlines.size(), 1u);
    const internal::StraightOutline corners = internal::straightened(outlines[0]);
    EXPECT_LE(corners.size(), 8u) << "four sides, and steps where a corner has been cut off";
    double along = 0;
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const Vector2d a = kCell * corners[k], b = kCell * corners[(k + 1) % corners.size()];
      if ((b - a).norm() < wall.length / 2) continue;
      const Vector2d direction = Eigen::Rotation2Dd(-wall.yaw) * (b - a).normalized();
      const double in_cells = std::abs(direction.y()) * wall.length / kCell;
      EXPECT_LT(in_cells, 1.5) << "half a cell at either end, and a corner that the side has taken along";
      turned += in_cells, ++sides;
      EXPECT_NEAR(std::abs(wall.own((a + b) / 2).y()), wall.width / 2, kCell / 2) << "on one of its faces";
      along += (b - a).norm();
    }
    EXPECT_NEAR(along, 2 * wall.length, 6 * kCell);
  }
  EXPECT_EQ(sides, 400);
  EXPECT_LT(turned / sides, 0.35);
}

TEST(FloorPlan, StandsInTheWorldOfTheGrid) {
  OccupancyGrid grid = drawn({{{2, 3}, 2, 0.2, 0}}, 100, 0.05);
  grid.origin = {-7, 11}, grid.yaw = 30 * kDegree;
  FloorPlanParams params;
  params.wall_height = 2.2;
  const MeshSurface surface(extrude(grid, params));
  EXPECT_NEAR(surface.bounds().min().z(), 0, 1e-6);
  EXPECT_NEAR(surface.bounds().max().z(), 2.2, 1e-6);
  // View from a metre before the middle of the wall's face, 1.2 m above the floor, level, towards the wall.
  const Eigen::Isometry2d T_w_grid = grid.T_w_grid();
  const Vector2d eye = T_w_grid * Vector2d(2, 1.9);
  Eigen::Isometry3d T_w_c = Eigen::Isometry3d::Identity();
  const Vector2d ahead = T_w_grid.linear() * Vector2d(0, 1);
  T_w_c.linear().col(0) = Eigen::Vector3d(ahead.y(), -ahead.x(), 0);
  T_w_c.linear().col(1) = -Eigen::Vector3d::UnitZ();
  T_w_c.linear().col(2) = Eigen::Vector3d(ahead.x(), ahead.y(), 0);
  T_w_c.translation() << eye, 1.2;
  const Intrinsics k{64, 48, 57, 57, 31.5, 23.5};
  const DepthImage image = surface.render(k, T_w_c);
  for (const int u : {0, 32, 63}) EXPECT_NEAR(image.at(u, 20), 1, 1e-3) << u;
}

TEST(FloorPlan, HasFloorAndCeilingWhereThePlanIsKnown) {
  OccupancyGrid grid = drawn({{{1, 1}, 1, 0.2, 0}}, 100, 0.05);
  for (int row = 0; row < 100; ++row)  // an L that is not known
    for (int column = 60; column < 100; ++column)
      if (row >= 30) grid.cells[grid.index(column, row)] = OccupancyGrid::kUnknown;
  FloorPlanParams params;
  params.ceiling = true;
  const auto depthDown = [&](double x, double y, bool up) {
    const MeshSurface surface(extrude(grid, params));
    Eigen::Isometry3d T_w_c = Eigen::Isometry3d::Identity();
    if (!up) T_w_c.linear() = Eigen::AngleAxisd(180 * kDegree, Eigen::Vector3d::UnitX()).toRotationMatrix();
    T_w_c.translation() << x, y, 1;
    return surface.render({3, 3, 100, 100, 1, 1}, T_w_c).at(1, 1);
  };
  EXPECT_NEAR(depthDown(4, 1, false), 1, 1e-5);
  EXPECT_NEAR(depthDown(4, 1, true), 1.5, 1e-5);
  EXPECT_EQ(depthDown(4, 2, false), 0) << "no floor is invented";
  params.floor = params.ceiling = false;
  EXPECT_EQ(depthDown(4, 1, false), 0);
}

/** A room of 4 x 4 m with an open side, beyond which nothing is known, and neither is a spot within. */
TEST(FloorPlan, CamerasAreAboveFreeCellsOnly) {
  OccupancyGrid grid = drawn(
      {{{3, 1}, 4.2, 0.2, 0}, {{3, 5}, 4.2, 0.2, 0}, {{1, 3}, 0.2, 4, 0}, {{5, 2}, 0.2, 2, 0}}, 120, 0.05);
  for (int row = 0; row < 120; ++row)
    for (int column = 0; column < 120; ++column) {
      const Vector2d p = grid.centre(column, row);
      const bool is_in_room = (p.array() > 1).all() && (p.array() < 5).all();
      if ((!is_in_room || (p - Vector2d(2, 4)).norm() < 0.5) && !grid.isOccupied(column, row))
        grid.cells[grid.index(column, row)] = OccupancyGrid::kUnknown;
    }
  grid.origin = {-7, 11}, grid.yaw = 30 * kDegree;
  const auto surface = std::make_shared<const FloorPlanSurface>(grid);
  const auto isFree = [&](double x, double y) {
    const Vector2d p = grid.T_w_grid() * Vector2d(x, y);
    return surface->isFree({p.x(), p.y(), 1});
  };
  EXPECT_TRUE(isFree(3, 3));
  for (const auto& [x, y] :
       {std::pair(2.0, 4.0), {1.0, 3.0}, {5.5, 4.0}, {-0.01, 3.0}, {3.0, 6.01}, {1e12, 0.0}})
    EXPECT_FALSE(isFree(x, y)) << x << ", " << y;

  ModelMapParams few;
  few.turn_deg = 60;
  for (const bool mounted : {true, false}) {
    Camera camera;
    camera.intrinsics = kinectIntrinsics().subsampled(4);
    if (mounted) camera.mounting = CameraMounting{0.95, 8};
    ModelMap making(surface, camera, few);
    EXPECT_FALSE(making.finish().models.empty()) << making.findings().problem;
    for (const Eigen::Isometry3d& T_w_c : making.findings().viewpoints) {
      const Vector2d cell = grid.cellOf(T_w_c.translation().head<2>());
      EXPECT_TRUE(grid.isFree(static_cast<int>(cell.x()), static_cast<int>(cell.y()))) << cell.transpose();
    }
  }
}

TEST(FloorPlan, LeavesOutSpots) {
  const std::vector<DrawnWall> walls = {{{1, 1}, 1, 0.2, 0}, {{3, 3}, 0.1, 0.1, 0}};
  FloorPlanParams params;
  params.floor = false;
  EXPECT_LT(MeshSurface(extrude(drawn(walls, 100, 0.05), params)).bounds().max().x(), 2);
  params.smallest = 0.1;
  EXPECT_GT(MeshSurface(extrude(drawn(walls, 100, 0.05), params)).bounds().max().x(), 3);
  EXPECT_TRUE(extrude(drawn({}, 100, 0.05)).polygons.empty());
  params.wall_height = -1;
  EXPECT_THROW(extrude(drawn(walls, 100, 0.05), params), std::invalid_argument);
}

}  // namespace
}  // namespace facetloc
