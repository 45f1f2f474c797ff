// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "depth/depth_consistency.h"
#include "depth/loose_bodies.h"
#include "nearby/view_alignment.h"
#include "poses/pose_fusion.h"

#include <facetloc/features/local_model.h>
#include <facetloc/features/map_metadata.h>
#include <facetloc/registration/hypothesis.h>
#include <facetloc/registration/registration_params.h>

#include <array>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <tuple>
#include <vector>

namespace facetloc::internal {

/** \brief Log odds of a score against the null hypothesis: the list lacks the place of the view. */
struct ScoreOdds {
  double slope = 0;       ///< [1/nat]
  double null_score = 0;  ///< [nats]

  double operator()(double score) const { return slope * (score - null_score); }
};

/** \brief The pixels' evidence about a hypothesis. */
struct PixelVerdict {
  PoseWithCovariance T_m_c;  ///< refined, or as it was
  std::optional<Eigen::Isometry3d> T_w_c;
  double evidence = 0;  ///< [nats]
  Coverage coverage;
  bool compared = false;         ///< with any local model
  LooseBodies::Chosen hiding{};  ///< bodies of the scene that stand before the map
};

/** \brief The pixels' evidence about the hypotheses of one scene, so that a list that grows is compared and
 * refined anew only where it is new. */
class PixelVerdicts {
public:
  /** \brief The verdict on a hypothesis with T_w_c, computed at the first request. \param refined is it one
   * after refinement? \param left_out bodies of the scene \param judge () -> PixelVerdict */
  template <typename Judge>
  const PixelVerdict& of(const Hypothesis& h, bool refined, const LooseBodies::Chosen& left_out,
                         Judge&& judge) {
    Key key{h.model, {}, refined, left_out};
    Eigen::Map<Eigen::Matrix4d>(std::get<1>(key).data()) = h.T_w_c->matrix();
    const auto known = verdicts_.find(key);
    return known != verdicts_.end() ? known->second : verdicts_.emplace(key, judge()).first->second;
  }
  /** \brief The bodies of the scene. */
  const LooseBodies& bodiesOf(const View& scene) { return bodies_ ? *bodies_ : bodies_.emplace(scene); }

private:
  using Key = std::tuple<int, std::array<double, 16>, bool, LooseBodies::Chosen>;
  std::map<Key, PixelVerdict> verdicts_;
  std::optional<LooseBodies> bodies_;
};

/** \brief A view near a hypothesis. */
struct NearbyView {
  std::shared_ptr<const View> view;
  Eigen::Isometry3d T_w_m;
  int model = 0;  ///< index of the local model that it is of
};

struct DepthEvidence;

/** \brief Makes hypotheses one ranked list of places: evidence, merging, refinement, probabilities. Which
 * views are near a hypothesis, and how scores become probabilities, differ between a map and a pair of views.
 * Never changes; all functions are thread-safe. */
class HypothesisRanking {
public:
  virtual ~HypothesisRanking() = default;

  /** \brief Ranks hypotheses of a scene, with T_w_c where it is known. A place that has evidence and was
   * found by n local models independently gets w_s ln n more [nats]. \param known of this scene, from lists
   * that were ranked before; the answer is the same without */
  void rank(const View& scene, std::vector<Hypothesis>& hypotheses, PixelVerdicts& known) const;
  void rank(const View& scene, std::vector<Hypothesis>& hypotheses) const {
    PixelVerdicts nothing;
    rank(scene, hypotheses, nothing);
  }

  /** \brief Scores the best hypotheses by the depth of the local models nearest to their world poses,
   * whichever generated them, instead of their own model's alone (localization/METHOD 1.1). The score is the
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
  bool addEvidence(const View& scene, std::vector<Hypothesis>& hypotheses, PixelVerdicts& known) const;

  /** \brief Refines the poses of the best places by all pixels (refineByDepth) and weighs their evidence
   * again, with the errors that a refined pose leaves; merges and scores. For places that have evidence. */
  void refinePlaces(const View& scene, std::vector<Hypothesis>& hypotheses, PixelVerdicts& known) const;

  /** \brief Bodies of a view that the map shows at a hypothesis with T_w_c: they are furniture. */
  LooseBodies::Chosen furnitureAt(const Hypothesis& h, const LooseBodies& bodies) const;

  /** \brief Gives the first place and all that are possible, which stay where they are, the covariance that
   * the cost shows (METHOD 11.4), and all places the errors that no pixel shows. \param prior_of T_m_c that
   * the hypotheses of a local model were found with, positive definite */
  void stateAsShown(const View& scene, const std::function<PoseWithCovariance(int model)>& prior_of,
                    std::vector<Hypothesis>& hypotheses) const;

  /** \brief The shares of a scene and of the views near a hypothesis; nothing where none of these
   * has depth there. */
  std::optional<ViewShares> shares(const View& scene, const Hypothesis& h) const;

protected:
  /** \param surfaces the kind of surfaces in views near a hypothesis (localization/METHOD 1.7)
   * \param errors of poses among these views, which no pixel shows */
  explicit HypothesisRanking(const RegistrationParams& params, MapSurfaces surfaces = MapSurfaces::seen,
                             const ConsideredErrors& errors = {});

  /** \brief The views near a hypothesis that has T_w_c. */
  virtual std::vector<NearbyView> neighbours(const Hypothesis& h) const = 0;
  /** \brief Pose of the local model that generated a hypothesis with T_w_c. */
  virtual Eigen::Isometry3d poseOfModel(const Hypothesis& h) const = 0;
  /** \brief Number of viewpoints of some local models, which count as independent. */
  virtual int viewpoints(const std::vector<int>& models) const = 0;
  /** \brief Weight of the evidence beside the consensus. */
  virtual double evidenceWeight() const = 0;
  /** \brief Score by pixels alone; it counts where it is the higher one [nats]. */
  virtual double scoreByPixels(const View& scene, const Hypothesis& h) const {
    static_cast<void>(scene), static_cast<void>(h);
    return -std::numeric_limits<double>::infinity();
  }
  /** \brief Odds of the scores of a sorted list. */
  virtual ScoreOdds odds(bool evidence, const std::vector<Hypothesis>& sorted) const = 0;

  /** \brief Evidence of views for a hypothesis [nats]; also sets h.coverage. Bodies of the scene that stand
   * before the surfaces of the views are left out if that explains more (localization/METHOD 1.1). */
  double evidence(const View& scene, const LooseBodies& bodies, const std::vector<NearbyView>& neighbours,
                  Hypothesis& h, const DepthComparison& comparison) const;
  /** \brief How depth is compared at poses before or after refinement. */
  const DepthComparison& comparison(bool refined) const {
    return refined ? refined_comparison_ : comparison_;
  }

private:
  // The pictures of the scene, each with the views near its own camera.
  DepthEvidence compared(const DepthPicture& depth, const View& scene,
                         const std::vector<NearbyView>& neighbours, const Hypothesis& h,
                         const DepthComparison& comparison) const;
  void refine(const View& scene, const std::vector<NearbyView>& neighbours, Hypothesis& h) const;
  double evidenceOf(const DepthPicture& depth, const View& scene, const std::vector<NearbyView>& neighbours,
                    Hypothesis& h, const DepthComparison& comparison) const;
  Matrix6d shownCovariance(const View& scene, const LooseBodies& bodies, const PoseWithCovariance& prior,
                           const Hypothesis& h) const;
  PixelVerdict verdict(const View& scene, const LooseBodies& bodies, Hypothesis h, bool refined) const;
  std::vector<PixelVerdict> verdicts(const View& scene, const std::vector<Hypothesis>& hypotheses,
                                     std::size_t n, bool refined, PixelVerdicts& known) const;
  void score(std::vector<Hypothesis>& places) const;
  std::size_t hopeful(const std::vector<Hypothesis>& sorted, int most, double slope) const;

  RegistrationParams params_;
  MapSurfaces surfaces_;
  ConsideredErrors errors_;
  DepthComparison comparison_, refined_comparison_;
};

/** \brief Sorts by score and merges hypotheses of one place into the best of them, which tells which local
 * models have found it. */
void mergePlaces(const MergingParams& params, std::vector<Hypothesis>& hypotheses);

/** \brief Gives each place of a sorted list its probability: softmax of slope times score, with a null place.
 * A pose within kSameAnswer of a better one is the same answer, found less well, and hands its
 * probability on. */
void assignProbabilities(double slope, double null_score, std::vector<Hypothesis>& hypotheses);

/** \brief A camera turned about its optical axis by n quarters. */
Eigen::Isometry3d quarterTurns(int n);
/** \brief Counts the prior odds of a turned camera: one of ten with unknown mounting is. */
void discountTurned(Localization& answer);

/** \brief Sets whether the covariance of the first pose fixes it, and the reason if it does not. */
void concludePose(const PoseLimits& limits, Localization& answer);

/** \brief Odds of the score of a pose of two views. */
ScoreOdds oddsOfPair(const RegistrationParams& params, bool evidence);

}  // namespace facetloc::internal
