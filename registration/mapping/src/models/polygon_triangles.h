// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <vector>

namespace facetloc::internal {

/** \brief Triangles of a polygon, as indices of its corners, in the polygon's direction of rotation.
 *
 * A fan from the first corner where it stays within the polygon, as in every convex one; else by ear clipping
 * in the plane of Newell's normal. Corners may be collinear, or be there twice, as where a cut leads to a
 * hole. A fan again for polygons that cross themselves, and for those of more than 10 000 corners
 * (METHOD 3.1). \param corners finite */
std::vector<std::array<std::uint32_t, 3>> polygonTriangles(const std::vector<Eigen::Vector3f>& corners);

}  // namespace facetloc::internal
