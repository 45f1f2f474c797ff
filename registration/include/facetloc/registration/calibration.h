// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/params.h>

namespace facetloc {

/** \brief How the inverse depths of two pictures are compared (METHOD 8.1). */
struct DepthCalibration {
  static constexpr const char* kTitle = "Comparison of depth pictures";
  double absolute_error = 3.0;
  double relative_error = 0.01;
  double gate = 3.0;
  double max_depth = 6.0;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("absolute_error", p.absolute_error, 0.01, 1e3,
          "Error of a predicted inverse depth that is constant over distance [noise standard deviations].");
    visit("relative_error", p.relative_error, 0.0, 1.0,
          "Error of a predicted inverse depth that grows with it, as a share of it.");
    visit("gate", p.gate, 0.1, 100.0,
          "Largest difference of two inverse depths that agree [standard deviations of the error].");
    visit("max_depth", p.max_depth, 0.1, 1e3, "Distance beyond which pixels are not compared [m].");
  }
};

/** \brief Log likelihood ratio of a hypothesis by the segments and the depth of its own local model (METHOD
 * 10). */
struct ScoreCalibration {
  static constexpr const char* kTitle = "Score of a hypothesis by its own local model";
  double match_probability = 0.9;
  double slope_slack_deg = 1.0;
  double offset_slack = 0.02;
  double max_offset = 6.0;
  double parallel_weight = 0.5;
  double coplanar_weight = 0.8;
  double free_space_weight = 6.9;
  double free_space_share = 0.005;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("match_probability", p.match_probability, 0.01, 0.999,
          "pi_m: probability that a visible surface of the scene is in the local model.");
    visit("slope_slack_deg", p.slope_slack_deg, 0.0, 45.0,
          "s_o: slack of slopes beyond their uncertainty, standard deviation [deg].");
    visit("offset_slack", p.offset_slack, 0.0, 10.0,
          "r_o: slack of offsets beyond their uncertainty, standard deviation [m].");
    visit("max_offset", p.max_offset, 0.1, 1e3, "rho_max: largest offset of a plane seen by chance [m].");
    visit("parallel_weight", p.parallel_weight, 0.0, 0.99,
          "mu: share of chance planes that are parallel to one already seen.");
    visit("coplanar_weight", p.coplanar_weight, 0.0, 0.99,
          "Share of the parallel chance planes that are another part of a plane already seen; 0 counts each "
          "part of a wall as independent evidence.");
    visit(
        "free_space_weight", p.free_space_weight, 0.0, 1e4,
        "w: weight of depth pixels that contradict a hypothesis, in each direction [nats]; 0 ignores them.");
    visit("free_space_share", p.free_space_share, 1e-6, 1.0,
          "c_0: share of contradicting depth pixels that hardly counts against a hypothesis.");
  }
};

/** \brief Evidence of the local models nearest to a place (localization/METHOD 1). */
struct EvidenceCalibration {
  static constexpr const char* kTitle = "Weight of the evidence of nearby local models";
  double hopeless_odds = 0.003;
  double contradiction_weight = 10;
  double occlusion_weight = 4;
  double disagreement_weight = 48;
  double untested_pixels = 0.01;
  double untested_contradiction = 0.15;
  double support_weight = 8;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("hopeless_odds", p.hopeless_odds, 0.0, 1.0,
          "Odds against the best hypothesis below which neither evidence nor refinement is computed.");
    visit(
        "contradiction_weight", p.contradiction_weight, 0.0, 1e4,
        "w_c: weight of depth pixels that contradict local models, or that local models contradict [nats].");
    visit("occlusion_weight", p.occlusion_weight, 0.0, 1e4,
          "w_o: weight of depth pixels of local models that are hidden in the scene [nats].");
    visit("disagreement_weight", p.disagreement_weight, 0.0, 1e4,
          "w_d: weight of depth pixels of the scene that do not agree with local models [nats].");
    visit("untested_pixels", p.untested_pixels, 0.0, 1.0,
          "Weight of the prior on the contradicted share, as a share of the pixels.");
    visit("untested_contradiction", p.untested_contradiction, 0.0, 1.0, "Prior of the contradicted share.");
    visit("support_weight", p.support_weight, 0.0, 1e4,
          "w_s: weight of the logarithm of the number of local models that found a place [nats].");
  }
};

/** \brief How pixels are compared at a pose that all of them have refined (localization/METHOD 1.3). */
struct RefinedDepthCalibration {
  static constexpr const char* kTitle = "Comparison of depth pictures at a refined pose";
  double absolute_error = 1.6;
  double relative_error = 0.003;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("absolute_error", p.absolute_error, 0.0, 1e3,
          "Error of a predicted inverse depth at a refined pose that is constant over distance [noise "
          "standard deviations].");
    visit("relative_error", p.relative_error, 0.0, 1.0,
          "Error of a predicted inverse depth at a refined pose that grows with it, as a share of it.");
  }
};

/** \brief Calibration from scores to probabilities, for places with evidence of nearby local models
 * (localization/METHOD 1.5). */
struct ProbabilityCalibration {
  static constexpr const char* kTitle = "Probability of a place with evidence of nearby local models";
  double slope = 0.09;
  int runners_up = 3;
  double runners_up_weight = 0.44;
  double null_score = 21;
  double least_null_score = -13;
  double ambiguity_weight = 0.29;
  double distinct_weight = 0.6;
  double distinct_scale = 30;
  double usual_ambiguity = 5;
  double usual_views = 20;
  double distinct_views = 5;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("slope", p.slope, 0.0001, 10.0, "beta: slope of the log odds in the score [1/nat].");
    visit("runners_up", p.runners_up, 1, 100000,
          "Number of places after the best whose mean score enters the null score.");
    visit("runners_up_weight", p.runners_up_weight, 0.0, 1.0,
          "Weight of the mean score of the runners-up in the null score.");
    visit("null_score", p.null_score, -1e4, 1e4,
          "Null score where neither the runners-up nor wrong places for the map's own views score [nats].");
    visit("least_null_score", p.least_null_score, -1e4, 1e4,
          "Smallest null score, however low the runners-up score [nats].");
    visit("ambiguity_weight", p.ambiguity_weight, 0.0, 10.0,
          "Weight of the scores that wrong places have for the map's own views, in the null score.");
    visit("distinct_weight", p.distinct_weight, 0.0, 10.0,
          "The same weight where these scores are negative: no two places of the map look the same.");
    visit("distinct_scale", p.distinct_scale, 1.0, 1e4,
          "Negative score of wrong places at which beta has grown by a factor of e [nats].");
    visit("usual_ambiguity", p.usual_ambiguity, -1e4, 1e4,
          "Score of wrong places in a map whose ambiguity was not measured [nats].");
    visit("usual_views", p.usual_views, 0.0, 1e4,
          "Number of own views of a map beside which the usual score counts as much as theirs.");
    visit("distinct_views", p.distinct_views, 0.0, 1e4, "The same number where theirs is the lower one.");
  }
};

/** \brief Calibration from scores to probabilities without evidence: no world poses, or no depth pictures. */
struct PlainProbabilityCalibration {
  static constexpr const char* kTitle = "Probability of a place without evidence of nearby local models";
  double slope = 0.155;
  double null_score = 22.3;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("slope", p.slope, 0.0001, 10.0, "Slope of the log odds in a score without evidence [1/nat].");
    visit("null_score", p.null_score, -1e4, 1e4,
          "Score without evidence at which a place is as likely as none of the list [nats].");
  }
};

/** \brief Calibration of probabilities in a map of one local model: two registered views. There are
 * no other places whose scores would show those of wrong ones, and one picture is less evidence than several.
 */
struct PairProbabilityCalibration {
  static constexpr const char* kTitle = "Probability of a pose of two views";
  double slope = 0.159;
  double null_score = 12;
  double evidence_weight = 0.31;
  double segments_slope = 0.105;
  double segments_null_score = 28.6;
  double agreement_weight = 2.02;
  double overlap_weight = 1.5;
  double pixels_null = 2.97;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("slope", p.slope, 0.0001, 10.0,
          "Slope of the log odds in the score of segments and depth [1/nat].");
    visit("null_score", p.null_score, -1e4, 1e4,
          "Score at which a pose is as likely as that the two views have nothing in common [nats].");
    visit("evidence_weight", p.evidence_weight, 0.0, 10.0, "Weight of the depth beside the segments.");
    visit("segments_slope", p.segments_slope, 0.0001, 10.0,
          "Slope of the log odds in the score of segments alone [1/nat].");
    visit("segments_null_score", p.segments_null_score, -1e4, 1e4, "Null score of segments alone [nats].");
    visit("agreement_weight", p.agreement_weight, 0.0, 100.0,
          "Weight of the log ratio of agreeing to contradicting pixels, in the log odds of pixels alone.");
    visit("overlap_weight", p.overlap_weight, 0.0, 100.0,
          "Weight of the log share of pixels that the other view shows, in the log odds of pixels alone.");
    visit("pixels_null", p.pixels_null, -100.0, 1e4,
          "What both together have to exceed to be as likely as nothing in common [nats].");
  }
};

/** \brief How the views of a sequence add up to a belief (localization/METHOD 3). */
struct SequenceCalibration {
  static constexpr const char* kTitle = "Weight of a view in a sequence";
  double independent_distance = 0.5;
  double independent_rotation_deg = 15;
  double lookalike_weight = 0.8;
  double lookalike_share_of_place = 0.5;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("independent_distance", p.independent_distance, 1e-3, 100.0,
          "Distance travelled after which a view counts nearly as much as a first one [m].");
    visit("independent_rotation_deg", p.independent_rotation_deg, 0.1, 360.0,
          "Rotation after which a view counts nearly as much as a first one [deg].");
    visit("lookalike_weight", p.lookalike_weight, 0.0, 1.0,
          "Weight of the scores of wrong places for the map's own views in the null score of a known place; "
          "the rest is the least null score.");
    visit("lookalike_share_of_place", p.lookalike_share_of_place, 0.0, 1.0,
          "Weight of wrong matches of the place's own views in these scores; the rest are the most ambiguous "
          "places of the "
          "map.");
  }
};

/** \brief Constants that were fitted together, on simulated floors of known truth, so that probabilities mean
 * frequencies. They are replaced as a whole or not at all: by a calibration of one's own, or with one set to
 * 0 to measure its worth. Not options of the tools; a file of parameters may contain them, as
 * apps/calibration.ini does. */
struct Calibration {
  static constexpr const char* kTitle = "Calibration";
  DepthCalibration depth;
  ScoreCalibration score;
  EvidenceCalibration evidence;
  RefinedDepthCalibration refined_depth;
  ProbabilityCalibration probability;
  PlainProbabilityCalibration plain_probability;
  PairProbabilityCalibration pair_probability;
  SequenceCalibration sequence;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("depth", p.depth);
    visit("score", p.score);
    visit("evidence", p.evidence);
    visit("refined_depth", p.refined_depth);
    visit("probability", p.probability);
    visit("plain_probability", p.plain_probability);
    visit("pair_probability", p.pair_probability);
    visit("sequence", p.sequence);
  }
};

}  // namespace facetloc
