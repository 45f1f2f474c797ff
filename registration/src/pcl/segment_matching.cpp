// SPDX-License-Identifier: BSD-3-Clause
#include "pcl/segment_frames.h"

#include <facetloc/features/segment_estimation.h>
#include <facetloc/registration/pose_prior.h>
#include <facetloc/registration/segment_matching.h>

#include <pcl/impl/pcl_base.hpp>

#include <algorithm>
#include <map>

namespace facetloc {

using namespace internal;

SegmentMatching::SegmentMatching() {
  corr_name_ = "SegmentMatching";
  pose_.P = posePrior({});
}

void SegmentMatching::determineCorrespondences(pcl::Correspondences& correspondences, double max_distance) {
  correspondences.clear();
  if (!input_ || !target_) return;
  const RankedFrames source = rankedSegments(*input_, use_indices_ ? indices_.get() : nullptr),
                     target = rankedSegments(*target_, target_indices_.get());
  MatchingParams params = params_;
  params.coplanarity_gate = std::min(params.coplanarity_gate, max_distance);
  for (const SegmentPair& p : candidatePairs(source.segments, target.segments, pose_, params))
    correspondences.emplace_back(source.index[p.scene], target.index[p.model],
                                 static_cast<float>(p.distance));
}

void SegmentMatching::determineReciprocalCorrespondences(pcl::Correspondences& correspondences,
                                                         double max_distance) {
  pcl::Correspondences all;
  determineCorrespondences(all, max_distance);
  std::map<int, float> best_of_source, best_of_target;
  for (const pcl::Correspondence& c : all) {
    const auto lower = [&c](std::map<int, float>& best, int i) {
      const auto [it, is_new] = best.emplace(i, c.distance);
      if (!is_new) it->second = std::min(it->second, c.distance);
    };
    lower(best_of_source, c.index_query);
    lower(best_of_target, c.index_match);
  }
  correspondences.clear();
  for (const pcl::Correspondence& c : all)
    if (c.distance == best_of_source[c.index_query] && c.distance == best_of_target[c.index_match])
      correspondences.push_back(c);
}

}  // namespace facetloc
