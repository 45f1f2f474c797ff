// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>
#include <facetloc/features/params.h>
#include <facetloc/registration/consensus.h>
#include <facetloc/registration/dense_refinement.h>
#include <facetloc/registration/depth_consistency.h>
#include <facetloc/registration/hypothesis.h>
#include <facetloc/registration/nearby_models.h>

#include <memory>
#include <vector>

namespace facetloc {

/** \brief How the hypotheses of all local models become one ranked list of places
 * (METHOD_MEASURED 11.4-11.6). */
struct PlaceRankingParams {
  bool multi_model = true;           ///< evidence of the nearest local models
  int evidence_models = 5;           ///< so many of them
  int evidence_hypotheses = 60;      ///< for so many of the best hypotheses
  double hopeless_odds = 0.003;      ///< against the best: neither evidence nor refinement makes up for less
  double contradiction_weight = 10;  ///< of contradicting pixels, in each direction [nats]; 0 = none
  double occlusion_weight = 4;       ///< of what the models saw and the scene hides, in the same form [nats]
  double disagreement_weight = 48;   ///< of a scene none of whose pixels agree with the models [nats]
  double untested_pixels =
      0.01;  ///< share of the pixels that contradict by untested_contradiction beforehand
  double untested_contradiction = 0.15;  ///< share of contradicting pixels that a pose has until it is tested
  double support_weight = 8;        ///< of the logarithm of the number of models that found a place [nats]
  bool merge = true;                ///< hypotheses of one place become one
  double merge_translation = 0.15;  ///< [m]
  double merge_rotation_deg = 2.0;
  bool dense_refinement = true;  ///< poses of the best places are refined by all pixels
  int refined_places = 12;       ///< so many of them
  DenseRefinementParams dense;
  double refined_absolute_error = 1.6;    ///< as depth_absolute_error, once refined [noise std]
  double refined_relative_error = 0.003;  ///< as depth_relative_error, once refined
  double softmax_slope = 0.11;            ///< beta of the probability [1/nat]
  int runners_up = 3;                  ///< places after the best, whose mean score tells what wrong ones have
  double runners_up_weight = 0.54;     ///< of that mean in S_0, see nullScore
  double null_score = 10;              ///< S_0 of a view whose runners-up score 0 [nats]
  double least_null_score = -14;       ///< S_0 if runners-up have hardly any score, or there is none [nats]
  double plain_softmax_slope = 0.155;  ///< the same for scores without evidence of local models
  double plain_null_score = 22.3;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& field) {
    field("multi_model", p.multi_model, false, true,
          "Test the best hypotheses against the nearest local models, whichever generated them.");
    field("evidence_models", p.evidence_models, 1, 100, "Number of local models that give evidence.");
    field("evidence_hypotheses", p.evidence_hypotheses, 1, 100000,
          "Number of best hypotheses that are tested so.");
    field("hopeless_odds", p.hopeless_odds, 0.0, 1.0,
          "Hypotheses whose odds against the best are worse are not looked at more closely.");
    field("contradiction_weight", p.contradiction_weight, 0.0, 1e4,
          "Weight of depth pixels that contradict local models or are contradicted by them [nats].");
    field("occlusion_weight", p.occlusion_weight, 0.0, 1e4,
          "Weight of depth pixels of local models that are hidden in the scene [nats].");
    field("disagreement_weight", p.disagreement_weight, 0.0, 1e4,
          "Weight of depth pixels of the scene that do not agree with local models [nats].");
    field("untested_pixels", p.untested_pixels, 0.0, 1.0,
          "Share of the pixels that a pose brings along as untested ones.");
    field("untested_contradiction", p.untested_contradiction, 0.0, 1.0,
          "Share of contradicting pixels among the untested ones.");
    field("support_weight", p.support_weight, 0.0, 1e4,
          "Weight of the logarithm of the number of local models that found a place [nats].");
    field("merge_places", p.merge, false, true, "Report hypotheses of one place once.");
    field("merge_translation", p.merge_translation, 0.0, 10.0,
          "World poses nearer than this and merge_rotation_deg are one place [m].");
    field("merge_rotation_deg", p.merge_rotation_deg, 0.0, 180.0,
          "World poses nearer than this and merge_translation are one place [deg].");
    field("dense_refinement", p.dense_refinement, false, true,
          "Refine the poses of the best places by all depth pixels.");
    field("refined_places", p.refined_places, 1, 100000, "Number of best places that are refined.");
    DenseRefinementParams::describe(p.dense, field);
    field("refined_absolute_error", p.refined_absolute_error, 0.0, 1e3,
          "Error of a predicted inverse depth at a refined pose [noise standard deviations].");
    field("refined_relative_error", p.refined_relative_error, 0.0, 1.0,
          "Relative error of a predicted inverse depth at a refined pose.");
    field("softmax_slope", p.softmax_slope, 0.0001, 10.0, "Slope of the probability in the score [1/nat].");
    field("null_score", p.null_score, -1e4, 1e4,
          "Score at which a place is as likely as none of the list, where the runners-up score 0 [nats].");
    field("runners_up", p.runners_up, 1, 100000,
          "Number of places after the best whose mean score raises or lowers the null score.");
    field("runners_up_weight", p.runners_up_weight, 0.0, 1.0, "Weight of that mean in the null score.");
    field("least_null_score", p.least_null_score, -1e4, 1e4,
          "Null score at least, however little the runners-up score [nats].");
    field("plain_softmax_slope", p.plain_softmax_slope, 0.0001, 10.0,
          "The same slope for scores without evidence of local models [1/nat].");
    field("plain_null_score", p.plain_null_score, -1e4, 1e4,
          "The same score where there is no evidence of local models [nats].");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief How depth is compared at a pose that all pixels have refined. */
DepthConsistencyParams refinedErrors(DepthConsistencyParams depth, const PlaceRankingParams& params);

/** \brief Makes the hypotheses of all local models of a map one ranked list of places. Never changes; all
 * functions are thread-safe. */
class PlaceRanking {
public:
  /** \param depth errors of predicted depth at poses that are not refined
   * \param inverse_depth_std the sensor's noise of inverse depth [1/m] */
  PlaceRanking(std::shared_ptr<const Map> map, const PlaceRankingParams& params,
               const ConsensusParams& consensus, const DepthConsistencyParams& depth,
               double inverse_depth_std);

  /** \brief The whole of it: evidence, merging, refinement, probabilities. A place that has evidence and was
   * found by n local models, each for itself, gets w_s ln n more [nats]. */
  void rank(const View& scene, std::vector<Hypothesis>& hypotheses) const;

  /** \brief Scores the best hypotheses by the depth of the local models nearest to their world poses,
   * whichever generated them, instead of their own model's alone (METHOD_MEASURED 11.4 (6)). The score is the
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
   * none: no world poses, no depth. */
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
  std::vector<Neighbour> neighbours(const Eigen::Isometry3d& T_w_c) const;
  double evidence(const View& scene, const std::vector<Neighbour>& neighbours, const Eigen::Isometry3d& T_w_c,
                  const DepthComparison& comparison) const;
  void refine(const View& scene, const std::vector<Neighbour>& neighbours, Hypothesis& h) const;
  int viewpoints(const std::vector<int>& models) const;
  void score(std::vector<Hypothesis>& places) const;
  std::size_t hopeful(const std::vector<Hypothesis>& sorted, int most, double slope) const;

  std::shared_ptr<const Map> map_;
  PlaceRankingParams params_;
  ConsensusParams consensus_;
  DepthComparison comparison_, refined_comparison_;
  double inverse_depth_std_;
  NearbyModels near_;
};

/** \brief Sorts by score and merges hypotheses of one place into the best of them, which tells which local
 * models have found it. */
void mergePlaces(const PlaceRankingParams& params, std::vector<Hypothesis>& hypotheses);

/** \brief Score at which a place that has evidence is as likely as none of the list [nats]:
 *
 *     S_0 = max(least_null_score, null_score + runners_up_weight * mean score of the next best places).
 *
 * What those score is a sample of what wrong places score in this view, in this map: a bare view, and a large
 * map, has many that score high, and the best one has to score higher to be believed. */
double nullScore(const PlaceRankingParams& params, const std::vector<Hypothesis>& sorted);

/** \brief Gives each place of a sorted list its probability: softmax of slope times score, with a null place.
 */
void assignProbabilities(double slope, double null_score, std::vector<Hypothesis>& hypotheses);

}  // namespace facetloc
