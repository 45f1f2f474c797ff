// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <vector>

namespace facetloc::internal {

using Polygon = std::vector<Eigen::Vector2d>;

/** \brief Convex hull by monotone chain, in the turning sense of +x to +y. \param points sorted by one
 * coordinate, then by the other; fewer than three are their own hull */
void convexHull(const Polygon& points, Polygon& hull);

/** \brief Drops the vertex whose loss costs the least area until at most n remain. */
void simplify(Polygon& hull, std::size_t n);

}  // namespace facetloc::internal
