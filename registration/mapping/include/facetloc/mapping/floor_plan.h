// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>
#include <facetloc/features/occupancy_grid.h>
#include <facetloc/features/params.h>
#include <facetloc/mapping/mesh_surface.h>

#include <pcl/PolygonMesh.h>

namespace facetloc {

/** \brief Limits of obstacles for a 2-D robot. */
struct MapGridParams {
  static constexpr const char* kTitle = "Occupancy grid of a map";
  double resolution = 0.05;
  double lowest = 0.2;
  double highest = 1.8;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("resolution", p.resolution, 0.005, 1.0, "Side of a cell [m].", kForUsers);
    visit("lowest", p.lowest, 0.0, 100.0, "Minimum height of obstacles above the floor [m].", kForUsers);
    visit("highest", p.highest, 0.0, 100.0, "Maximum height of obstacles above the floor [m].", kForUsers);
  }
};

/** \brief Occupancy grid of a map, or of its largest part, in the axes of its world, whose z axis is up.
 *
 * A cell is occupied where depth pictures show points of upright segments within the band of heights, free
 * where only rays pass within the band, at any height, unknown otherwise. Where both were seen, most views
 * decide. The floor
 * is where the mounting of the map's camera puts it, or the lowest of the large level segments. Throws
 * std::runtime_error with a sentence for a map that has no poses, no depth pictures, no floor or more than 64
 * million cells, and std::invalid_argument for a parameter out of its range. */
OccupancyGrid gridOf(const Map& map, const MapGridParams& params = {});

/** \brief The third dimension of a floor plan. */
struct FloorPlanParams {
  static constexpr const char* kTitle = "Walls of a floor plan";
  double wall_height = 2.5;
  double smallest = 0.15;
  bool floor = true;
  bool ceiling = false;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("wall_height", p.wall_height, 0.1, 100.0, "Height of the walls above the floor [m].", kForUsers);
    visit("smallest", p.smallest, 0.0, 100.0,
          "Leave out occupied spots of the plan whose extent is less than this [m].", kForUsers);
    visit("floor", p.floor, false, true, "The floor is a plane, at z = 0 of the plan's frame.");
    visit("ceiling", p.ceiling, false, true, "The ceiling is a plane, at the height of the walls.",
          kForUsers);
  }
};

/** \brief Mesh of the walls of a floor plan, in the world of the grid, its floor at z = 0 [m] (METHOD 4.1).
 *
 * The outlines of the occupied cells are straightened: each side passes every edge of a cell that it stands
 * for within half a cell, and there are as few sides as that allows; so that a wall is one plane in its own
 * direction and no staircase of cells. Floor and ceiling cover the cells that are known. Empty for a plan
 * without walls. Throws std::invalid_argument for a parameter out of its range. */
pcl::PolygonMesh extrude(const OccupancyGrid& plan, const FloorPlanParams& params = {});

/** \brief The extruded floor plan as a surface that cameras see, before which furniture may stand. Cameras
 * are above free cells only, not above unknown ones or beside the plan. Throws std::invalid_argument for a
 * plan without walls and for a parameter out of its range. */
class FloorPlanSurface : public MeshSurface {
public:
  explicit FloorPlanSurface(OccupancyGrid plan, const FloorPlanParams& params = {});
  bool isIncomplete() const override { return true; }
  bool isFree(const Eigen::Vector3d& place) const override;
  /** \brief Standard deviation of the place of a wall that cells allow [m]. */
  double wallStd() const;

private:
  OccupancyGrid plan_;
};

}  // namespace facetloc
