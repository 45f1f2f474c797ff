// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/pose.h>
#include <facetloc/features/segment.h>

#include <vector>

namespace facetloc {

/** \brief Information of planes about the pose from which they are seen, in the order (rotation, translation)
 * in the camera's axes: each counts as measured twice with the same error. */
Matrix6d informationOf(const std::vector<Segment>& segments);

/** \brief Precision of a pose by measurements alone, without its prior: along the principal directions of
 * P_meas = (Lambda + weak prior)^-1. The weak prior of METHOD 6.3, 30 deg and 10 m on every axis, only makes
 * the sum invertible. */
PrincipalStd observability(const Matrix6d& information);

}  // namespace facetloc
