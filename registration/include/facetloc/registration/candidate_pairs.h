// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/pose.h>
#include <facetloc/features/segment.h>
#include <facetloc/registration/hypothesis.h>
#include <facetloc/registration/registration_params.h>

#include <vector>

namespace facetloc {

/** \brief All candidate pairs under a pose prior, the most promising first: by the sum of the ranks of both
 * segments (METHOD 4.3), ties by scene, then model index. Only the first max_segments segments of each list
 * are used; both must be sorted by information content. */
std::vector<SegmentPair> candidatePairs(const std::vector<Segment>& scene, const std::vector<Segment>& model,
                                        const PoseWithCovariance& prior, const MatchingParams& params = {});

}  // namespace facetloc
