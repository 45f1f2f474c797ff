// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/gravity.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

namespace facetloc {

/** \brief The direction of gravity as a camera with an inertial sensor measures it at each image: in its
 * optical frame, turned by independent errors about each of two horizontal axes. Same seed, same errors.
 * \param T_w_c the true poses, z up \param std of each error [rad] */
std::vector<Gravity> simulateGravity(const std::vector<Eigen::Isometry3d>& T_w_c, double std,
                                     std::uint64_t seed);

}  // namespace facetloc
