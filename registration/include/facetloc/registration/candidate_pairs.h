// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/params.h>
#include <facetloc/features/segment.h>

#include <limits>
#include <vector>

namespace facetloc {

/** \brief When a scene and a model segment may be the same surface (METHOD 9). */
struct MatchingParams {
  double coplanarity_gate = 11.345;  ///< EPS_1 on d^2, chi2(3) at 99 %
  double overlap_gate = 11.345;      ///< EPS_2 on the distance of the centroids
  int max_segments = 30;             ///< N_dom: the most informative segments of each image

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& field) {
    field("coplanarity_gate", p.coplanarity_gate, 0.1, 1e6,
          "Largest squared Mahalanobis distance between the planes of a pair.");
    field("overlap_gate", p.overlap_gate, 0.1, 1e6,
          "Largest squared Mahalanobis distance between the outlines of a pair.");
    field("max_segments", p.max_segments, 1, 64,
          "Number of most informative segments of an image that generate hypotheses.");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief A pair (scene segment, model segment) that may be the same surface. */
struct SegmentPair {
  int scene = 0;
  int model = 0;
  double distance = 0;  ///< squared Mahalanobis distance of the planes
};

/** \brief Coplanarity criterion: d^2 of the pair under the pose uncertainty. Infinity if the normals are
 * further apart than the cosine allows, or if d^2 certainly exceeds the gate. */
double coplanarityDistance(const Segment& scene, const Segment& model, const PoseWithCovariance& T_m_c,
                           double gate = std::numeric_limits<double>::infinity(), double min_cosine = 0);

/** \brief Overlap criterion (METHOD 9.2): squared Mahalanobis distance of the centroids under shapes and
 * pose; the shape of each counts as its 50 % ellipse, the pose at full uncertainty. Beyond the gate it may be
 * a lower bound of it. */
double overlapDistance(const Segment& scene, const Segment& model, const PoseWithCovariance& T_m_c,
                       double gate = std::numeric_limits<double>::infinity());

/** \brief All candidate pairs under a pose prior, the most promising first: by the sum of the ranks of both
 * segments (METHOD 10.2), ties by scene, then model index. Only the first max_segments segments of each list
 * are used; both must be sorted by information content. */
std::vector<SegmentPair> candidatePairs(const std::vector<Segment>& scene, const std::vector<Segment>& model,
                                        const PoseWithCovariance& prior, const MatchingParams& params = {});

}  // namespace facetloc
