// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "pairs/ekf_pose_update.h"

#include <facetloc/registration/hypothesis.h>

#include <optional>
#include <vector>

namespace facetloc::internal {

/** \brief A position along a direction that is known from elsewhere: v . t = value. */
struct TranslationConstraint {
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< v, unit, in model axes
  double value = 0;                                     ///< [m]
  double std = 0;                                       ///< [m]
};

/** \brief Re-estimates a hypothesis from all pairs that agree with it (METHOD 7): the maximum a posteriori
 * pose by Gauss-Newton with Huber weights, independent of any order; pairs are collected twice. Replaces
 * pose, covariance and pairs; false, and no change, if no pair agrees.
 * \param chosen if not null, the only pairs that count \param extents whether the places of the segments in
 * their planes count, too (ExtentMeasurement) */
bool refineJointly(const std::vector<Segment>& scene, const std::vector<Segment>& model,
                   const PoseWithCovariance& prior, const MatchingParams& matching,
                   const std::optional<TranslationConstraint>& constraint, Hypothesis& hypothesis,
                   const std::vector<SegmentPair>* chosen = nullptr, bool extents = false);

}  // namespace facetloc::internal
