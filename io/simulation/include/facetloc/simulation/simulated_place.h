// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/occupancy_grid.h>

#include <Eigen/Geometry>
#include <pcl/PolygonMesh.h>

#include <cstdint>
#include <string>
#include <vector>

namespace facetloc {

/** \brief How a surface answers the projector of a depth camera. */
enum class Material : std::uint8_t {
  matt,
  dark,  ///< reflects so little that patches of it are lost, more of them far away and at grazing angles
  glass  ///< is seen only in patches; most rays go on to the surface behind
};

/** \brief A one-coloured rectangle of the simulated world: centre, two unit axes and half sizes [m]; seen
 * from both sides. Rectangles of the same plane id are one plane in the true labels. */
struct Rectangle {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis_u = Eigen::Vector3d::UnitX();
  Eigen::Vector3d axis_v = Eigen::Vector3d::UnitY();
  double half_u = 1;
  double half_v = 1;
  std::uint16_t plane_id = 1;
  Material material = Material::matt;

  Eigen::Vector3d normal() const { return axis_u.cross(axis_v); }
};

/** \brief A curved thing, which is no plane and has the label 0: an ellipsoid, or an upright cylinder
 * (open at its ends), in its own frame, with half sizes along its axes [m]. */
struct RoundBody {
  enum class Shape : std::uint8_t { ellipsoid, cylinder };
  Shape shape = Shape::ellipsoid;
  Eigen::Isometry3d T_w_b = Eigen::Isometry3d::Identity();
  Eigen::Vector3d half_size = Eigen::Vector3d::Ones();
  Material material = Material::matt;
};

/** \brief How far surfaces are from where a world says: each is moved along its normal by a smooth function
 * of the place on it, another one for each plane id. */
struct SurfaceBending {
  double std = 0;          ///< standard deviation of the displacement [m]; 0 = surfaces without errors
  double length = 2;       ///< shortest wavelength [m]; the longest is three times that
  std::uint64_t seed = 1;  ///< the same seed, the same surfaces
};

/** \brief The surfaces that a simulated camera can see; z up, floor at z = 0. */
struct SimulatedWorld {
  std::vector<Rectangle> rectangles;
  std::vector<RoundBody> bodies;
  SurfaceBending bending{};
};

/** \brief Adds the six faces of a box (centre, orientation, half sizes); plane ids count up from next_id. */
void addBox(SimulatedWorld& world, const Eigen::Isometry3d& T_w_box, const Eigen::Vector3d& half_size,
            std::uint16_t& next_id);
/** \brief A closed room of random size with random boxes on its floor and walls, z up, floor at z = 0. The
 * middle, within 0.8 m of the z axis, is free for a camera. Same seed, same room. */
SimulatedWorld randomRoom(std::uint64_t seed, int boxes = 8);

/** \brief A place on a robot's way, and its actions there before it goes on straight to the next one. */
struct Waypoint {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  ///< [m]
  double look_deg = 0;  ///< turns on the spot by this angle, to the left if positive
};

/** \brief A way that a robot drives again and again: from the last waypoint it goes on to the first. */
using Route = std::vector<Waypoint>;

/** \brief Convex outline of something solid in the floor plan, counterclockwise [m]. */
using PlanOutline = std::vector<Eigen::Vector2d>;

/** \brief A whole floor as it is when a robot maps it, and as it is later: some furniture and doors have
 * moved.
 *
 * A plane that is the same in both has the same id; moved planes have new ones. */
struct SimulatedPlace {
  SimulatedWorld mapped;  ///< when the map is made
  SimulatedWorld later;   ///< when the robot comes back
  Route mapping_route;
  Route query_route;                                ///< another line through the same places
  std::vector<Eigen::AlignedBox2d> unmapped_rooms;  ///< on the query route only
  std::vector<PlanOutline> walls;                   ///< and pillars, as a floor plan shows them
  std::vector<PlanOutline> doorways;                ///< openings of the walls that begin at the floor
  bool one_way = false;                             ///< the routes end at their last waypoints
};

/** \brief The names of the places that there are: office, home, hall, corridor, hotel, boards, doors, box. */
const std::vector<std::string>& simulatedPlaceNames();
/** \brief The place of that name, generated from the seed; the same seed gives the same place. Throws
 * std::invalid_argument for an unknown name.
 *
 * - office: a loop of corridors with doors in recesses, some of them ajar, windows, pillars, beams,
 *   cupboards, bins and notice boards, all equal on purpose, and a few rooms that are open.
 * - home: furnished rooms.
 * - hall: shelves, columns and large distances.
 * - corridor: 40 m long and bare, driven along once: but for its ends, out of range for most of the way,
 *   no surface reveals how far along it a camera is.
 * - hotel: twelve rooms off one corridor, equal inside; doors and the things beside them differ.
 * - boards: a bare floor with some flat boards, driven over; nothing else is in sight. For a camera that
 *   looks down.
 * - doors: a corridor driven along once, with closed doors every 1.8 m, all equal, and three things that
 * stand beside them.
 * - box: a cabinet on a bare floor, driven around, which looks the same from opposite sides. */
SimulatedPlace simulatedPlace(const std::string& name, std::uint64_t seed);

/** \brief The part of a place that is the same in both of its worlds: without movable things. */
SimulatedWorld lastingParts(const SimulatedPlace& place);

/** \brief Mesh of the visible surfaces of a world, without their bending: no glass; round bodies have 24
 * sides. Triangles of float x, y, z [m]. */
pcl::PolygonMesh meshOf(const SimulatedWorld& world);

/** \brief Occupancy grid of the walls of a place as a plan shows them: whole at their windows, open at doors,
 * without doors and furniture. Free is the floor that the robot can reach without a door that it never drives
 * through; the rest is unknown. Throws
 * std::invalid_argument for a place without walls. \param resolution side of a cell [m], positive */
OccupancyGrid floorPlanOf(const SimulatedPlace& place, double resolution = 0.05);

}  // namespace facetloc
