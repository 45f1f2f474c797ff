// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "pairs/consensus.h"
#include "pairs/depth_alignment.h"
#include "pairs/hypothesis_tree.h"
#include "pairs/joint_refinement.h"

#include <facetloc/registration/registration_params.h>

namespace facetloc::internal {

/** \brief Registers a view with one local model: match, search, refine, complete by depth, score. Never
 * changes; thread-safe. */
class ViewRegistration {
public:
  explicit ViewRegistration(const ViewRegistrationParams& params = {});
  const ViewRegistrationParams& params() const { return params_; }
  const HypothesisScore& score() const { return score_; }

  /** \brief False if the planes of a view tell so little that align() has no answer, whatever the model. */
  bool mayFixPose(const Query& query) const;

  /** \param start about where correspondences are looked for: the query's prior, or another estimate of the
   * pose \param chosen if not null, the only pairs that may correspond, in place of candidatePairs() \return
   * hypotheses by decreasing score (consensus and free-space term; no world pose, no probability) */
  std::vector<Hypothesis> align(const Query& query, const View& model, const PoseWithCovariance& start,
                                const std::vector<SegmentPair>* chosen = nullptr) const;
  std::vector<Hypothesis> align(const Query& query, const View& model) const {
    return align(query, model, query.prior);
  }
  /** \brief Poses that the planes of a view leave open, completed by where their segments are (METHOD 6.6):
   * coarse, so that they count only where align() has no answer. Without depth assistance. */
  std::vector<Hypothesis> alignByExtents(const Query& query, const View& model,
                                         const PoseWithCovariance& start,
                                         const std::vector<SegmentPair>* chosen = nullptr) const;
  /** \brief The hypothesis next to a start, from all pairs that agree there, without a search; none if no
   * pair does. Its score is as of align(), from fewer pixels. A tenth of the work of align(). */
  std::optional<Hypothesis> alignFrom(const PoseWithCovariance& start, const Query& query, const View& model,
                                      const std::vector<SegmentPair>* chosen = nullptr) const;

private:
  using Chosen = const std::vector<SegmentPair>*;
  TreeSearchResult search(const Query& query, const View& model, const PoseWithCovariance& start,
                          Chosen chosen, bool extents) const;
  std::vector<Hypothesis> scored(const Query& query, const View& model,
                                 std::vector<Hypothesis> hypotheses) const;
  void addComplete(const Query& query, const View& model, const std::vector<PoseNode>& complete,
                   Chosen chosen, bool extents, std::vector<Hypothesis>& hypotheses) const;
  void addDistinct(const Query& query, Hypothesis&& h, std::vector<Hypothesis>& hypotheses) const;
  void completeByDepth(const Query& query, const View& model, const std::vector<PoseNode>& incomplete,
                       Chosen chosen, std::vector<Hypothesis>& hypotheses) const;

  ViewRegistrationParams params_;
  DepthComparison comparison_;
  HypothesisScore score_;
};

/** \brief Which motions of the camera the segments of a view leave free, in words and camera axes, such as
 * "translation along (1.00, 0.02, 0.00)"; empty if they, with the prior information, fix all six degrees
 * of freedom. */
std::string unconstrainedDirections(const Query& query, const HypothesisTreeParams& params);

/** \brief Why a view has no hypothesis, in words. */
std::string whyNoHypothesis(const Query& query, const HypothesisTreeParams& params);

}  // namespace facetloc::internal
