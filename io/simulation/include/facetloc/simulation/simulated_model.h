// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/occupancy_grid.h>
#include <facetloc/simulation/simulated_place.h>

#include <pcl/PolygonMesh.h>

namespace facetloc {

/** \brief The part of a place that is the same in both of its scenes: without movable things. */
Scene lastingParts(const SimulatedPlace& place);

/** \brief Mesh of the visible surfaces of a scene, without their bending: no glass; round bodies have 24
 * sides. Triangles of float x, y, z [m]. */
pcl::PolygonMesh meshOf(const Scene& scene);

/** \brief Occupancy grid of the walls of a place as a plan shows them: whole at their windows, open at doors,
 * without doors and furniture. Free is the floor that the robot can reach without a door that it never drives
 * through; the rest is unknown. Throws
 * std::invalid_argument for a place without walls. \param resolution side of a cell [m], positive */
OccupancyGrid floorPlanOf(const SimulatedPlace& place, double resolution = 0.05);

}  // namespace facetloc
