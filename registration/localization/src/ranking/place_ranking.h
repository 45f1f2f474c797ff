// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "depth/dense_refinement.h"
#include "depth/depth_consistency.h"
#include "nearby/nearby_models.h"
#include "nearby/view_alignment.h"
#include "pairs/consensus.h"
#include "shared/pose_radius.h"

#include <facetloc/features/local_model.h>
#include <facetloc/localization/localization_params.h>
#include <facetloc/registration/hypothesis.h>

#include <memory>
#include <optional>
#include <vector>

namespace facetloc::internal {

/** \brief How depth is compared at a pose that all pixels have refined. */
DepthCalibration refinedErrors(const Calibration& calibration);

/** \brief From a score to log odds against that a list lacks the place of a view. */
struct ScoreOdds {
  double slope = 0;       ///< [1/nat]
  double null_score = 0;  ///< [nats]

  double operator()(double score) const { return slope * (score - null_score); }
};

/** \brief Makes the hypotheses of all local models of a map one ranked list of places. Never changes; all
 * functions are thread-safe. */
class PlaceRanking {
public:
  PlaceRanking(std::shared_ptr<const Map> map, const GlobalLocalizationParams& params);

  /** \brief The whole of it: evidence, merging, refinement, probabilities. A place that has evidence and was
   * found by n local models, each for itself, gets w_s ln n more [nats]. */
  void rank(const View& scene, std::vector<Hypothesis>& hypotheses) const;

  /** \brief A place that is known from elsewhere, aligned with the local models around it and scored as if a
   * search had found it there. Nothing if there are none, for then the map says nothing.
   * \param T_w_c in the frame of that part of the map, the prior of the alignment, positive definite */
  std::optional<Hypothesis> at(const Query& query, int part, const PoseWithCovariance& T_w_c) const;
  /** \brief Can local models give evidence of where a view was taken: have they, and has it, depth? */
  bool mayHaveEvidence(const View& scene) const;
  /** \brief Of the scores of a list of places, sorted, that a search has found. */
  ScoreOdds odds(bool evidence, const std::vector<Hypothesis>& sorted) const;
  /** \brief Of the score of a place that was known before the view, and is not the best of many therefore.
   * With evidence, S_0 lies between least_null_score and what look-alikes score, nearer to that by their
   * weight from 0 to 1; those of the local models around the place have a share from 0 to 1 in it, those of
   * the whole map the rest (METHOD 16.6). */
  ScoreOdds oddsOfKnown(bool evidence, double lookalike_weight, double share_of_place,
                        const Hypothesis& place) const;

  /** \brief Scores the best hypotheses by the depth of the local models nearest to their world poses,
   * whichever generated them, instead of their own model's alone (METHOD 11.1). The score is the
   * consensus minus
   *
   *     w_c (ln(1 + c / c_0) + mean ln(1 + c_m / c_0)) + w_o mean ln(1 + o_m / c_0) + w_d d   [nats]
   *
   * c: share of the scene's pixels that contradict the models (more of them than agree with it); c_m, o_m:
   * share of model m's pixels that contradict the scene, and that are hidden in it; d: share of the scene's
   * pixels that are compared and do not agree. The mean is over models, not over pixels: a passer-by in one
   * of them spoils its own term only. A pose that hardly any pixel tests counts as contradicted like most
   * wrong ones.
   *
   * Hypotheses beyond the best ones get the least evidence of those. False, and no change, where there is
   * none: no poses of local models, no depth. */
  bool addEvidence(const View& scene, std::vector<Hypothesis>& hypotheses) const;

  /** \brief Refines the poses of the best places by all pixels (refineByDepth) and weighs their evidence
   * again, with the errors that a refined pose leaves; merges and scores. For places that have evidence. */
  void refinePlaces(const View& scene, std::vector<Hypothesis>& hypotheses) const;

private:
  /** \brief A local model near a place. */
  struct Neighbour {
    std::shared_ptr<const View> view;
    Eigen::Isometry3d T_w_m;
  };
  std::vector<Neighbour> neighbours(const Hypothesis& h) const;
  double evidence(const View& scene, const std::vector<Neighbour>& neighbours, Hypothesis& h,
                  const DepthComparison& comparison) const;
  void refine(const View& scene, const std::vector<Neighbour>& neighbours, Hypothesis& h) const;
  double together(const Hypothesis& h) const;
  double lookalikesOf(const Hypothesis& place, double share_of_place) const;
  int viewpoints(const std::vector<int>& models) const;
  void score(std::vector<Hypothesis>& places) const;
  std::size_t hopeful(const std::vector<Hypothesis>& sorted, int most, double slope) const;

  std::shared_ptr<const Map> map_;
  GlobalLocalizationParams params_;
  DepthComparison comparison_, refined_comparison_;
  std::unique_ptr<const HypothesisScore> score_;
  ViewAlignmentParams alignment_;
  NearbyModels near_;
};

/** \brief Sorts by score and merges hypotheses of one place into the best of them, which tells which local
 * models have found it. */
void mergePlaces(const MergingParams& params, std::vector<Hypothesis>& hypotheses);

/** \brief Score at which a place that has evidence is as likely as none of the list [nats]:
 *
 *     S_0 = max(least_null_score, null_score + runners_up_weight * mean score of the next best places)
 *           + ambiguity_weight * A + ln(pi / (1 - pi)) / slope.
 *
 * What the next best places score is a sample of what wrong places score for this view. A is what they score
 * for other views of this map, which tells what a place would score that only looks like one which the map
 * lacks; of few views, it is drawn towards the usual. pi: map_incomplete. */
double nullScore(const ProbabilityCalibration& calibration, const ProbabilityParams& prior,
                 const std::optional<MapAmbiguity>& ambiguity, const std::vector<Hypothesis>& sorted);

/** \brief Gives each place of a sorted list its probability: softmax of slope times score, with a null place.
 * A pose within kSameAnswer of a better one is the same answer, found less well, and hands its
 * probability on. */
void assignProbabilities(double slope, double null_score, std::vector<Hypothesis>& hypotheses);

}  // namespace facetloc::internal
