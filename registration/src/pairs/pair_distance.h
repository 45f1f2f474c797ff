// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/pose.h>
#include <facetloc/features/segment.h>

#include <limits>

namespace facetloc::internal {

/** \brief Coplanarity criterion: d^2 of the pair under the pose uncertainty. Infinity if the normals are
 * further apart than the cosine allows, or if d^2 certainly exceeds the gate. */
double coplanarityDistance(const Segment& scene, const Segment& model, const PoseWithCovariance& T_m_c,
                           double gate = std::numeric_limits<double>::infinity(), double min_cosine = 0);

/** \brief Overlap criterion (METHOD 4.2): squared Mahalanobis distance of the centroids under shapes and
 * pose; the shape of each counts as its 50 % ellipse, the pose at full uncertainty. Beyond the gate it may be
 * a lower bound of it. */
double overlapDistance(const Segment& scene, const Segment& model, const PoseWithCovariance& T_m_c,
                       double gate = std::numeric_limits<double>::infinity());

}  // namespace facetloc::internal
