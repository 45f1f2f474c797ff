// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/pair_distance.h"

#include <facetloc/registration/candidate_pairs.h>

#include <algorithm>

namespace facetloc {

using namespace internal;

std::vector<SegmentPair> candidatePairs(const std::vector<Segment>& scene, const std::vector<Segment>& model,
                                        const PoseWithCovariance& prior, const MatchingParams& params) {
  std::vector<SegmentPair> pairs;
  const int n = std::min<int>(scene.size(), params.max_segments),
            m = std::min<int>(model.size(), params.max_segments);
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < m; ++k) {
      const double distance = coplanarityDistance(scene[i], model[k], prior, params.coplanarity_gate);
      if (!(distance <= params.coplanarity_gate)) continue;
      if (!(overlapDistance(scene[i], model[k], prior, params.overlap_gate) <= params.overlap_gate)) continue;
      pairs.push_back({i, k, distance});
    }
  std::stable_sort(pairs.begin(), pairs.end(), [](const SegmentPair& a, const SegmentPair& b) {
    return a.scene + a.model < b.scene + b.model;  // METHOD 4.3
  });
  return pairs;
}

}  // namespace facetloc
