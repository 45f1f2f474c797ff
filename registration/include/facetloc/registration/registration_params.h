// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/registration/calibration.h>
#include <facetloc/registration/pair_params.h>
#include <facetloc/registration/pose_prior.h>

#include <cmath>
#include <string>

namespace facetloc {

/** \brief How a hypothesis is scored by its own local model (METHOD 10). */
struct ConsensusParams {
  static constexpr const char* kTitle = "Score of a hypothesis";
  bool by_overlap = false;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("by_overlap", p.by_overlap, false, true,
          "Score by the overlap of segments, as the paper does, instead of the log likelihood ratio and "
          "depth; probabilities are then meaningless.");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief Evidence of the nearest local models for a world pose, whichever of them generated it. */
struct EvidenceParams {
  static constexpr const char* kTitle = "Evidence of the local models nearest to a place";
  bool enabled = true;
  int hypotheses = 60;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("enabled", p.enabled, false, true,
          "Test the best hypotheses against the depth of the nearest local models.");
    visit("hypotheses", p.hypotheses, 1, 100000, "Maximum number of hypotheses that are tested.");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief When hypotheses of several local models are one place. */
struct MergingParams {
  static constexpr const char* kTitle = "Merging of hypotheses of one place";
  bool enabled = true;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("enabled", p.enabled, false, true, "List hypotheses of one place once.");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief Refinement of the best places by all pixels of the nearest local models. */
struct PlaceRefinementParams {
  static constexpr const char* kTitle = "Refinement of the best places by all depth pixels";
  bool enabled = true;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("enabled", p.enabled, false, true, "Refine the poses of the best places by all depth pixels.");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief Limits on the uncertainty of a pose that one may act on. A sure answer is within them, whatever its
 * probability (localization/METHOD 11.8). */
struct PoseLimits {
  static constexpr const char* kTitle = "Uncertainty of a sure answer";
  double max_translation = 0.3;
  double max_rotation_deg = 5;

  /** \brief True if a covariance of a pose is within the limits. */
  bool hold(const Matrix6d& P) const;
  /** \brief "nothing in view fixes translation along (1.00, 0.00, 0.00)", of a pose that is not within them.
   * \param R turns axes of the frame of P into those of the words */
  std::string whyNotFixed(const Matrix6d& P, const Eigen::Matrix3d& R) const;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("max_translation", p.max_translation, 1e-3, 100.0,
          "Maximum position uncertainty of a sure answer, two standard deviations [m].", kForUsers);
    visit("max_rotation_deg", p.max_rotation_deg, 1e-3, 180.0,
          "Maximum orientation uncertainty of a sure answer, two standard deviations [deg].", kForUsers);
  }
  void validate() const { checkRanges(*this); }
};

/** \brief Parameters of the step from scores to probabilities. */
struct ProbabilityParams {
  static constexpr const char* kTitle = "Probability of a place";
  double map_incomplete = 0.5;

  /** \brief Prior log odds that the map lacks the place of a view [nats]. */
  double priorLogOdds() const { return std::log(map_incomplete / (1 - map_incomplete)); }

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("map_incomplete", p.map_incomplete, 0.001, 0.999,
          "Prior probability that the map lacks the place of a view. Lower it for a map that is known to be "
          "complete.",
          kForUsers);
  }
  void validate() const { checkRanges(*this); }
};

/** \brief How hypotheses of the pose of one view relative to another are found and scored. */
struct ViewRegistrationParams {
  static constexpr const char* kTitle = "Registration of two views";
  MatchingParams matching;
  EkfParams ekf;
  HypothesisTreeParams tree;
  RegistrationSteps steps;
  ConsensusParams score;
  Calibration calibration;  ///< no group of parameters: replaced as a whole

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("matching", p.matching);
    visit("ekf", p.ekf);
    visit("tree", p.tree);
    visit("steps", p.steps);
    visit("score", p.score);
  }
  /** \brief Throws std::invalid_argument for a parameter or a constant out of its range. */
  void validate() const { checkRanges(*this), calibration.validate(); }
};

/** \brief Parameters of the registration of two views: hypotheses, and the ranking of them. A field is known
 * by its path, such as `ekf.iterations`. */
struct RegistrationParams : ViewRegistrationParams {
  static constexpr const char* kTitle = "Registration of two views";
  PosePriorParams prior;
  EvidenceParams evidence;
  MergingParams merging;
  PlaceRefinementParams refinement;
  ProbabilityParams probability;
  PoseLimits sure;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("prior", p.prior);
    ViewRegistrationParams::describe(p, visit);
    describeRanking(p, visit);
  }
  template <class Self, class Visitor>
  static void describeRanking(Self& p, Visitor&& visit) {
    visit("evidence", p.evidence);
    visit("merging", p.merging);
    visit("refinement", p.refinement);
    visit("probability", p.probability);
    visit("sure", p.sure);
  }
  /** \brief Throws std::invalid_argument for a parameter or a constant out of its range. */
  void validate() const { checkRanges(*this), calibration.validate(); }
};

}  // namespace facetloc
