// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "pairs/ekf_pose_update.h"

#include <facetloc/registration/hypothesis.h>
#include <facetloc/registration/observability.h>
#include <facetloc/registration/registration_params.h>

#include <vector>

namespace facetloc::internal {

/** \brief A set of mutually consistent pairs and the pose that they give. */
struct PoseNode {
  PoseWithCovariance pose;
  Matrix6d information = Matrix6d::Zero();  ///< information of the pairs alone
  std::vector<SegmentPair> pairs;
  Eigen::Vector3d free_direction =
      Eigen::Vector3d::Zero();  ///< unit vector in model axes, for incomplete nodes
};

/** \brief Poses without duplicates, in the order found. */
struct FoundPoses {
  std::vector<PoseNode> complete;    ///< all six degrees of freedom are fixed
  std::vector<PoseNode> incomplete;  ///< exactly one translation is free
};

/** \brief The result of searching one local model. */
struct TreeSearchResult {
  FoundPoses by_pairs;
  FoundPoses with_known;             ///< poses that pairs fix only together with the prior information
  std::vector<PoseNode> by_extents;  ///< complete only by where the segments of the pairs are in their planes
  int expansions = 0;
};

/** \brief Searches the index-increasing sequences of candidate pairs in which no segment occurs twice; each
 * set of pairs is visited at most once, the ones of the best-ranked pairs first. Without the limits the
 * search is exhaustive over all gate-consistent sets.
 * \param known information about the pose that needs no pair, such as floorInformation()
 * \param extents whether poses that planes leave open are completed by ExtentMeasurement */
TreeSearchResult searchHypotheses(const std::vector<Segment>& scene, const std::vector<Segment>& model,
                                  const std::vector<SegmentPair>& candidates, const PoseWithCovariance& prior,
                                  const MatchingParams& matching, const EkfParams& ekf,
                                  const HypothesisTreeParams& params,
                                  const Matrix6d& known = Matrix6d::Zero(), bool extents = false);

}  // namespace facetloc::internal
