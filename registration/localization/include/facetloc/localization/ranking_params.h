// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/registration/depth_params.h>

namespace facetloc {

/** \brief What segments, and the depth of its own local model, say for a hypothesis (METHOD 10). */
struct ConsensusParams {
  static constexpr const char* kTitle = "Score of a hypothesis by its own local model";
  bool by_overlap = false;         ///< the paper's segment-overlap score alone: no depth terms
  double match_probability = 0.9;  ///< pi_m: that a visible, static surface is in the model
  double slope_slack_deg = 1.0;    ///< s_o
  double offset_slack = 0.02;      ///< r_o [m]
  double max_offset = 6.0;         ///< rho_max of the chance density [m]
  double parallel_weight = 0.5;  ///< mu: how much a direction already seen explains a further parallel plane
  double coplanar_weight = 0.8;  ///< of these: another part of the very plane
  double free_space_weight = 6.9;   ///< w of the free-space term, in each direction [nats]; 0 = none
  double free_space_share = 0.005;  ///< c_0, a share of contradicting pixels that says little

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit(
        "by_overlap", p.by_overlap, false, true,
        "Score by the overlap of segments, as the paper does, instead of the log likelihood ratio and depth; "
        "probabilities then mean nothing.");
    visit("match_probability", p.match_probability, 0.01, 0.999,
          "Probability that a visible surface of the scene is in the local model.");
    visit("slope_slack_deg", p.slope_slack_deg, 0.0, 45.0,
          "Slack of slopes beyond their uncertainty, standard deviation [deg].");
    visit("offset_slack", p.offset_slack, 0.0, 10.0,
          "Slack of offsets beyond their uncertainty, standard deviation [m].");
    visit("max_offset", p.max_offset, 0.1, 1e3, "Largest offset of a plane that is seen by chance [m].");
    visit("parallel_weight", p.parallel_weight, 0.0, 0.99,
          "Share of chance planes that are parallel to one already seen.");
    visit("coplanar_weight", p.coplanar_weight, 0.0, 0.99,
          "Share of the parallel chance planes that are another part of a plane already seen; 0 counts each "
          "part of "
          "a wall as evidence of its own.");
    visit(
        "free_space_weight", p.free_space_weight, 0.0, 1e4,
        "Weight of depth pixels that contradict a hypothesis, in each direction [nats]; 0 leaves them out.");
    visit("free_space_share", p.free_space_share, 1e-6, 1.0,
          "Share of contradicting depth pixels that says little against a hypothesis.");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief What the nearest local models say for a world pose, whichever of them generated it. */
struct EvidenceParams {
  static constexpr const char* kTitle = "Evidence of the local models nearest to a place";
  bool enabled = true;
  int models = 5;                    ///< so many of them
  int hypotheses = 60;               ///< for so many of the best hypotheses
  double hopeless_odds = 0.003;      ///< against the best: neither evidence nor refinement makes up for less
  double contradiction_weight = 10;  ///< of contradicting pixels, in each direction [nats]; 0 = none
  double occlusion_weight = 4;       ///< of what the models saw and the scene hides, in the same form [nats]
  double disagreement_weight = 48;   ///< of a scene none of whose pixels agree with the models [nats]
  double untested_pixels =
      0.01;  ///< share of the pixels that contradict by untested_contradiction beforehand
  double untested_contradiction = 0.15;  ///< share of contradicting pixels that a pose has until it is tested
  double support_weight = 8;  ///< of the logarithm of the number of models that found a place [nats]

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("enabled", p.enabled, false, true,
          "Test the best hypotheses against the depth of the nearest local models.");
    visit("models", p.models, 1, 100, "Number of local models that give evidence of a place.");
    visit("hypotheses", p.hypotheses, 1, 100000, "Largest number of hypotheses that are tested.");
    visit("hopeless_odds", p.hopeless_odds, 0.0, 1.0,
          "Odds against the best hypothesis below which one is not looked at more closely.");
    visit("contradiction_weight", p.contradiction_weight, 0.0, 1e4,
          "Weight of depth pixels that contradict local models or are contradicted by them [nats].");
    visit("occlusion_weight", p.occlusion_weight, 0.0, 1e4,
          "Weight of depth pixels of local models that are hidden in the scene [nats].");
    visit("disagreement_weight", p.disagreement_weight, 0.0, 1e4,
          "Weight of depth pixels of the scene that do not agree with local models [nats].");
    visit("untested_pixels", p.untested_pixels, 0.0, 1.0,
          "Share of the pixels that a pose brings along as if it had not been tested by them.");
    visit("untested_contradiction", p.untested_contradiction, 0.0, 1.0,
          "Share of contradicting pixels that is expected of a pose until it is tested.");
    visit("support_weight", p.support_weight, 0.0, 1e4,
          "Weight of the logarithm of the number of local models that found a place [nats].");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief When hypotheses of several local models are one place. */
struct MergingParams {
  static constexpr const char* kTitle = "Merging of hypotheses of one place";
  bool enabled = true;
  double translation = 0.15;  ///< [m]
  double rotation_deg = 2.0;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("enabled", p.enabled, false, true, "List hypotheses of one place once.");
    visit("translation", p.translation, 0.0, 10.0,
          "Distance of two world poses below which they are one place, if their orientations agree too [m].");
    visit(
        "rotation_deg", p.rotation_deg, 0.0, 180.0,
        "Angle between two world poses below which they are one place, if their positions agree too [deg].");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief Refinement of the best places by all pixels of the nearest local models. */
struct PlaceRefinementParams : DenseRefinementParams {
  static constexpr const char* kTitle = "Refinement of the best places by all depth pixels";
  bool enabled = true;
  int places = 12;                ///< so many of them
  double absolute_error = 1.6;    ///< as DepthConsistencyParams, at a refined pose [noise std]
  double relative_error = 0.003;  ///< as DepthConsistencyParams, at a refined pose
  double pixels_as_one = 50;      ///< so many tell as much of a refined pose as one: neighbours err alike

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("enabled", p.enabled, false, true, "Refine the poses of the best places by all depth pixels.");
    visit("places", p.places, 1, 100000, "Largest number of places that are refined.");
    DenseRefinementParams::describe(p, visit);
    visit("absolute_error", p.absolute_error, 0.0, 1e3,
          "Error of a predicted inverse depth at a refined pose that is the same at all distances [noise "
          "standard "
          "deviations].");
    visit("relative_error", p.relative_error, 0.0, 1.0,
          "Error of a predicted inverse depth at a refined pose that grows with it, as a share of it.");
    visit("pixels_as_one", p.pixels_as_one, 1.0, 1e9,
          "Number of pixels that tell as much of a refined pose as one of its own error would, by which its "
          "covariance shrinks where the sensor's distortion is taken out.");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief From scores to probabilities, for places that have evidence of local models. */
struct ProbabilityParams {
  static constexpr const char* kTitle = "Probability of a place";
  double slope = 0.09;              ///< beta of the softmax [1/nat]
  int runners_up = 3;               ///< places after the best, whose mean score tells what wrong ones have
  double runners_up_weight = 0.44;  ///< of that mean in S_0, see nullScore
  double null_score = 21;  ///< S_0 where neither runners-up nor the map's own wrong places score [nats]
  double least_null_score = -13;   ///< the same, if runners-up have hardly any score, or there is none [nats]
  double ambiguity_weight = 0.29;  ///< of what wrong places score for the map's own views, in S_0
  double usual_ambiguity = 5;      ///< of a map that was not asked about itself [nats]
  double map_incomplete = 0.5;  ///< probability, before the view is looked at, that the map lacks its place

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("slope", p.slope, 0.0001, 10.0, "Slope of the probability in the score [1/nat].");
    visit("runners_up", p.runners_up, 1, 100000,
          "Number of places after the best whose mean score raises or lowers the null score.");
    visit("runners_up_weight", p.runners_up_weight, 0.0, 1.0,
          "Weight of the mean score of the runners-up in the null score.");
    visit("null_score", p.null_score, -1e4, 1e4,
          "Score at which a place is as likely as none of the list, where neither runners-up nor wrong "
          "places for the "
          "map's own views have any [nats].");
    visit("ambiguity_weight", p.ambiguity_weight, 0.0, 10.0,
          "Weight of the scores that wrong places have for the map's own views, in the null score.");
    visit("usual_ambiguity", p.usual_ambiguity, -1e4, 1e4,
          "Score of wrong places that is expected of a map that was not asked about itself [nats].");
    visit("map_incomplete", p.map_incomplete, 0.001, 0.999,
          "Probability that the map does not hold the place of a view, before it is looked at; lower it for "
          "a map "
          "that is known to be complete.");
    visit("least_null_score", p.least_null_score, -1e4, 1e4,
          "Smallest null score, however little the runners-up score [nats].");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief From scores to probabilities where there is no evidence: no world poses, or no depth pictures. */
struct PlainProbabilityParams {
  static constexpr const char* kTitle = "Probability of a place without evidence of local models";
  double slope = 0.155;
  double null_score = 22.3;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("slope", p.slope, 0.0001, 10.0,
          "Slope of the probability in a score without evidence of local models [1/nat].");
    visit("null_score", p.null_score, -1e4, 1e4,
          "Score without evidence of local models at which a place is as likely as none of the list [nats].");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief From scores to probabilities in a map of one local model: two views that are registered. There are
 * no other places whose scores would tell what wrong ones have, and one picture says less than several. */
struct PairProbabilityParams {
  static constexpr const char* kTitle = "Probability of a pose of two views";
  double slope = 0.159;           ///< of the softmax in the score by segments and depth [1/nat]
  double null_score = 12;         ///< the same for none of the list [nats]
  double evidence_weight = 0.31;  ///< of what depth says, in that score
  double segments_slope = 0.105;  ///< where there are segments only
  double segments_null_score = 28.6;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("slope", p.slope, 0.0001, 10.0,
          "Slope of the probability of a pose of two views in its score [1/nat].");
    visit(
        "null_score", p.null_score, -1e4, 1e4,
        "Score of a pose of two views at which it is as likely as that they have nothing in common [nats].");
    visit("evidence_weight", p.evidence_weight, 0.0, 10.0,
          "Weight of the depth of two views beside their segments.");
    visit("segments_slope", p.segments_slope, 0.0001, 10.0,
          "Slope of the probability of a pose of two views without depth [1/nat].");
    visit("segments_null_score", p.segments_null_score, -1e4, 1e4,
          "Score of a pose of two views without depth at which it is as likely as that they have nothing in "
          "common [nats].");
  }
  void validate() const { checkRanges(*this); }
};

}  // namespace facetloc
