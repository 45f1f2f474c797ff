// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>
#include <facetloc/features/params.h>
#include <facetloc/registration/consensus.h>
#include <facetloc/registration/depth_consistency.h>
#include <facetloc/registration/hypothesis.h>

#include <vector>

namespace facetloc {

/** \brief How the hypotheses of all local models become one ranked list of places
 * (METHOD_MEASURED 11.4-11.6). */
struct PlaceRankingParams {
  bool multi_model = true;          ///< evidence of the nearest local models
  int evidence_models = 5;          ///< so many of them
  int evidence_hypotheses = 60;     ///< for so many of the best hypotheses
  double agreement_weight = 23;     ///< of a scene that agrees with them in all its pixels [nats]
  double occlusion_weight = 1.3;    ///< of what they saw and the scene hides, like free_space_weight [nats]
  bool merge = true;                ///< hypotheses of one place become one
  double merge_translation = 0.15;  ///< [m]
  double merge_rotation_deg = 2.0;
  double softmax_slope = 0.139;  ///< beta of the probability [1/nat]
  double null_score = 32.3;      ///< S_0: score at which a place is as likely as none of the list [nats]
  double plain_softmax_slope = 0.155;  ///< the same for scores without evidence of local models
  double plain_null_score = 22.3;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& field) {
    field("multi_model", p.multi_model, false, true,
          "Test the best hypotheses against the nearest local models, whichever generated them.");
    field("evidence_models", p.evidence_models, 1, 100, "Number of local models that give evidence.");
    field("evidence_hypotheses", p.evidence_hypotheses, 1, 100000,
          "Number of best hypotheses that are tested so.");
    field("agreement_weight", p.agreement_weight, 0.0, 1e4,
          "Evidence of local models for a scene that agrees with them in all its depth pixels [nats].");
    field("occlusion_weight", p.occlusion_weight, 0.0, 1e4,
          "Weight of depth pixels of local models that are hidden in the scene [nats].");
    field("merge_places", p.merge, false, true, "Report hypotheses of one place once.");
    field("merge_translation", p.merge_translation, 0.0, 10.0,
          "World poses nearer than this and merge_rotation_deg are one place [m].");
    field("merge_rotation_deg", p.merge_rotation_deg, 0.0, 180.0,
          "World poses nearer than this and merge_translation are one place [deg].");
    field("softmax_slope", p.softmax_slope, 0.0001, 10.0, "Slope of the probability in the score [1/nat].");
    field("null_score", p.null_score, -1e4, 1e4,
          "Score at which a place is as likely as none of the list [nats].");
    field("plain_softmax_slope", p.plain_softmax_slope, 0.0001, 10.0,
          "The same slope for scores without evidence of local models [1/nat].");
    field("plain_null_score", p.plain_null_score, -1e4, 1e4,
          "The same score where there is no evidence of local models [nats].");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief Scores the best hypotheses by the depth of the local models nearest to their world poses, whichever
 * generated them, instead of their own model's alone (METHOD_MEASURED 11.4 (6)): the consensus, plus the
 * share of the scene's pixels that agree, plus the free-space terms of both directions, minus what the models
 * saw and the scene hides.
 *
 * Hypotheses beyond the best ones get the least evidence of those. False, and no change, where there is none:
 * no world poses, no depth. */
bool addEvidence(const View& scene, const Map& map, const DepthComparison& comparison,
                 const ConsensusParams& consensus, const PlaceRankingParams& params,
                 std::vector<Hypothesis>& hypotheses);

/** \brief Sorts by score, merges hypotheses of one place into the best of them and gives each place its
 * probability by softmax with a null place; with_evidence tells which calibration fits the scores. */
void rankPlaces(const PlaceRankingParams& params, bool with_evidence, std::vector<Hypothesis>& hypotheses);

}  // namespace facetloc
