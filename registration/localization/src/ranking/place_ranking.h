// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "nearby/hypothesis_ranking.h"
#include "nearby/nearby_models.h"
#include "pairs/consensus.h"

#include <facetloc/features/local_model.h>
#include <facetloc/localization/localization_params.h>

#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace facetloc::internal {

/** \brief Ranks the hypotheses of all local models of a map. */
class PlaceRanking : public HypothesisRanking {
public:
  PlaceRanking(std::shared_ptr<const Map> map, const GlobalLocalizationParams& params);

  /** \brief Takes the evidence of these local models away from all places. */
  void leaveOut(const std::function<bool(int model)>& absent) { near_ = near_.without(absent); }

  /** \brief A place that is known from elsewhere, aligned with the local models around it and scored as if a
   * search had found it there. Nothing if there are none, for then the map says nothing.
   * \param T_w_c in the frame of that part of the map, the prior of the alignment, positive definite
   * \param bodies of the view */
  std::optional<Hypothesis> at(const Query& query, int part, const PoseWithCovariance& T_w_c,
                               const LooseBodies& bodies) const;
  /** \brief Log odds of another place against the right one by the views that the map expects at both: at
   * most 0, and 0 where there is little to compare. \param seen, here expected at the right place, by
   * different local models \param other expected at the other one; all have pictures only, as seen from one
   * pose */
  double oddsOfOther(const View& seen, const View& here, const View& other) const;
  /** \brief Can local models give evidence of where a view was taken: have they, and has it, depth? */
  bool mayHaveEvidence(const View& scene) const;
  ScoreOdds odds(bool evidence, const std::vector<Hypothesis>& sorted) const override;
  /** \brief Odds by the score of a place that was known before the view, and therefore is not the best of
   * many. With evidence, S_0 lies between least_null_score and the score of wrong matches, nearer to that by
   * lookalike_weight; those of the local models around the place have lookalike_share_of_place in it, those
   * of the whole map the rest (METHOD 3.5). */
  ScoreOdds oddsOfKnown(bool evidence, const Hypothesis& place) const;

private:
  std::vector<NearbyView> neighbours(const Hypothesis& h) const override;
  Eigen::Isometry3d poseOfModel(const Hypothesis& h) const override;
  int viewpoints(const std::vector<int>& models) const override;
  double evidenceWeight() const override;
  double aliasScoreOf(const Hypothesis& place) const;

  std::shared_ptr<const Map> map_;
  GlobalLocalizationParams params_;
  HypothesisScore score_;
  ViewAlignmentParams alignment_;
  NearbyModels near_;
  std::vector<char> rendered_;  // indexed by local model: true if others have shown all of it
};

/** \brief Score at which a place that has evidence is as likely as none of the list [nats]:
 *
 *     S_0 = max(least_null_score, null_score + runners_up_weight * mean score of the next best places)
 *           + ambiguity_weight * A + ln(pi / (1 - pi)) / slope.
 *
 * The scores of the next best places are a sample of those of wrong places for this view. A is their mean
 * for other views of this map, the expected score of a place that only looks like one, while the map
 * lacks it; of few views, it is drawn towards the usual. pi: map_incomplete. */
double nullScore(const ProbabilityCalibration& calibration, const ProbabilityParams& prior,
                 const std::optional<MapAmbiguity>& ambiguity, const std::vector<Hypothesis>& sorted);

}  // namespace facetloc::internal
