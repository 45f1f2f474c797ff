// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "pairs/consensus.h"
#include "pairs/hypothesis_tree.h"
#include "pairs/joint_refinement.h"

#include <facetloc/registration/registration_params.h>

namespace facetloc::internal {

/** \brief Registers a view with one local model: match, search, refine, complete by depth, score. Never
 * changes; thread-safe. */
class ViewRegistration {
public:
  explicit ViewRegistration(const ViewRegistrationParams& params = {});
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
  void addRefined(const Query& query, const View& model,
                  const std::optional<TranslationConstraint>& constraint, Chosen chosen, bool extents,
                  Hypothesis&& h, std::vector<Hypothesis>& hypotheses) const;
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

/** \brief Search for the last translation by dense depth (METHOD 9). */
struct DepthAlignmentParams {
  double range = 1.4;      ///< on both sides of the prior mean [m]
  double step = 0.1;       ///< spacing of the coarse search [m]: near a wall, pixels a step off do not agree
  double prominence = 12;  ///< margin of the best position over the mean [net agreements of the coarse grid]
  double runner_up = 8;    ///< how far below the best a second maximum may lie
  double std = 0.03;       ///< uncertainty of the found position [m]
};

/** \brief Positions along a unit direction at which both depth pictures agree best, best first, at most two;
 * empty if nothing along the direction distinguishes the positions.
 *
 * \param T_m_c pose whose translation along direction is not known; \param centre prior mean of direction . t
 * [m]. \return values of direction . t [m]. */
std::vector<double> alignDepth(const DepthPicture& scene, const DepthPicture& model,
                               const Eigen::Isometry3d& T_m_c, const Eigen::Vector3d& direction,
                               double centre, const DepthComparison& comparison,
                               const DepthAlignmentParams& params = {});

}  // namespace facetloc::internal
