// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/matched_segments.h"

#include <facetloc/registration/calibration.h>
#include <facetloc/registration/candidate_pairs.h>

#include <algorithm>
#include <map>

namespace facetloc {

std::vector<SegmentPair> matchedSegments(const View& scene, const View& model,
                                         const Eigen::Isometry3d& T_m_c) {
  const ScoreCalibration slack;  // as much as counts for agreement when a hypothesis is scored
  const double rotation_std = slack.slope_slack_deg * kDegree, translation_std = slack.offset_slack;
  PoseWithCovariance pose;
  pose.T = T_m_c;
  pose.P.setZero();
  pose.P.diagonal().head<3>().setConstant(rotation_std * rotation_std);
  pose.P.diagonal().tail<3>().setConstant(translation_std * translation_std);
  MatchingParams all;
  all.max_segments = static_cast<int>(std::max(scene.segments.size(), model.segments.size()));

  std::map<int, SegmentPair> best;  // keyed by scene segment
  for (const SegmentPair& pair : candidatePairs(scene.segments, model.segments, pose, all)) {
    const auto [found, is_new] = best.emplace(pair.scene, pair);
    if (!is_new && pair.distance < found->second.distance) found->second = pair;
  }
  std::vector<SegmentPair> pairs;
  for (const auto& [scene_segment, pair] : best) pairs.push_back(pair);
  return pairs;
}

}  // namespace facetloc
