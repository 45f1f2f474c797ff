// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/params.h>
#include <facetloc/features/pose.h>
#include <facetloc/registration/calibration.h>
#include <facetloc/registration/pose_prior.h>

#include <cmath>
#include <string>

namespace facetloc {

/** \brief When a scene and a model segment may be the same surface (METHOD 4). */
struct MatchingParams {
  static constexpr const char* kTitle = "Candidate pairs of segments";
  double coplanarity_gate = chiSquareQuantile(3, 0.99);
  double overlap_gate = chiSquareQuantile(3, 0.99);
  int max_segments = 30;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("coplanarity_gate", p.coplanarity_gate, 0.1, 1e6,
          "Largest squared Mahalanobis distance between the planes of a pair; 11.345 is chi-square of 3 "
          "degrees of "
          "freedom at 99 %.");
    visit("overlap_gate", p.overlap_gate, 0.1, 1e6,
          "Largest squared Mahalanobis distance between the outlines of a pair.");
    visit("max_segments", p.max_segments, 1, 64,
          "Number of most informative segments of each image that generate hypotheses; fewer are faster.",
          kForUsers);
  }
};

/** \brief The iterated Extended Kalman Filter for one pair of segments (METHOD 5). */
struct EkfParams {
  static constexpr const char* kTitle = "Kalman update of a pose by one pair of segments";
  int iterations = 20;
  double gate = chiSquareQuantile(3, 0.99);
  double min_cosine = 0.5;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit(
        "iterations", p.iterations, 1, 100,
        "Maximum number of linearisations of a Kalman update. Up to 8, the last state is accepted unchecked, "
        "as in a plain Extended Kalman Filter; with more, a pair that does not converge is rejected.");
    visit("gate", p.gate, 0.1, 1e6, "Largest post-fit cost of a pair, chi-square of 3 degrees of freedom.");
    visit("min_cosine", p.min_cosine, 0.0, 1.0,
          "Smallest cosine between the normals of a pair at the current pose.");
  }
};

/** \brief Best-first search for consistent sets of pairs (METHOD 6). */
struct HypothesisTreeParams {
  static constexpr const char* kTitle = "Search for consistent sets of pairs";
  int max_expansions = 700;
  int max_hypotheses = 10;
  int max_pairs = 6;
  double min_gain = 1.0;
  double angle_gate = 3.0;
  double complete_rotation_deg = 3.0;
  double complete_translation = 0.2;
  double duplicate_rotation_deg = 1.0;
  double duplicate_translation = 0.05;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("max_expansions", p.max_expansions, 1, 1000000,
          "Largest number of Kalman updates for one local model; fewer are faster.", kForUsers);
    visit("max_hypotheses", p.max_hypotheses, 1, 10000,
          "Largest number of distinct hypotheses of one local model.");
    visit("max_pairs", p.max_pairs, 1, 16,
          "Largest number of segment pairs that a hypothesis is searched with.");
    visit("min_gain", p.min_gain, 0.0, 100.0,
          "Information that a further pair must add to a hypothesis [nats].");
    visit("angle_gate", p.angle_gate, 0.1, 1e6,
          "Largest difference between the angles of two scene and two model normals [standard deviations].");
    visit("complete_rotation_deg", p.complete_rotation_deg, 0.01, 90.0,
          "Largest orientation uncertainty of a complete hypothesis, standard deviation [deg].");
    visit("complete_translation", p.complete_translation, 0.001, 100.0,
          "Largest position uncertainty of a complete hypothesis, standard deviation [m].");
    visit("duplicate_rotation_deg", p.duplicate_rotation_deg, 0.0, 90.0,
          "Angle below which two hypotheses of a local model are one, if they are as near in position too "
          "[deg].");
    visit("duplicate_translation", p.duplicate_translation, 0.0, 10.0,
          "Distance below which two hypotheses of a local model are one, if they are as near in orientation "
          "too "
          "[m].");
  }
};

/** \brief Steps of a registration that can be left out. */
struct RegistrationSteps {
  static constexpr const char* kTitle = "Steps of a registration that can be left out";
  bool joint_refinement = true;
  bool floor_information = true;
  bool depth_assistance = true;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("joint_refinement", p.joint_refinement, false, true,
          "Re-estimate each hypothesis from all pairs that agree with it.");
    visit("floor_information", p.floor_information, false, true,
          "Where planes alone fix no pose, use roll, pitch and height by the camera's mounting.");
    visit("depth_assistance", p.depth_assistance, false, true,
          "Find a translation that the planes leave free by comparing depth pictures.");
  }
};

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
};

/** \brief When hypotheses of several local models are one place. */
struct MergingParams {
  static constexpr const char* kTitle = "Merging of hypotheses of one place";
  bool enabled = true;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("enabled", p.enabled, false, true, "List hypotheses of one place once.");
  }
};

/** \brief Refinement of the best places by all pixels of the nearest local models. */
struct PlaceRefinementParams {
  static constexpr const char* kTitle = "Refinement of the best places by all depth pixels";
  bool enabled = true;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("enabled", p.enabled, false, true, "Refine the poses of the best places by all depth pixels.");
  }
};

/** \brief Limits on the uncertainty of a pose that one may act on. A sure answer is within them, whatever its
 * probability (localization/METHOD 1.8). */
struct PoseLimits {
  static constexpr const char* kTitle = "Uncertainty of a sure answer";
  double max_translation = 0.3;
  double max_rotation_deg = 5;

  /** \brief True if a covariance of a pose is within the limits. */
  bool hold(const Matrix6d& P) const;
  /** \brief "nothing in view fixes translation along (1.00, 0.00, 0.00)", of a pose that is not within them.
   * \param R turns axes of the frame of P into those of the words */
  std::string whyNotFixed(const Matrix6d& P, const Eigen::Matrix3d& R) const;
  /** \brief freeMotions() beyond the limits. */
  std::string openMotions(const PrincipalStd& known, const Eigen::Matrix3d& R) const;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("max_translation", p.max_translation, 1e-3, 100.0,
          "Maximum position uncertainty of a sure answer, two standard deviations [m].", kForUsers);
    visit("max_rotation_deg", p.max_rotation_deg, 1e-3, 180.0,
          "Maximum orientation uncertainty of a sure answer, two standard deviations [deg].", kForUsers);
  }
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
  void validate() const { checkRanges(*this), checkRanges(calibration); }
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
  void validate() const { checkRanges(*this), checkRanges(calibration); }
};

/** \brief How a camera moves from view to view, and which of its views are kept as keyframes. */
struct ViewOdometryParams {
  static constexpr const char* kTitle = "Motion of the camera from view to view";
  double key_distance = 0.3;
  double key_rotation_deg = 12;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("key_distance", p.key_distance, 0.0, 100.0,
          "Distance from all keyframes at which a new one is taken [m].");
    visit("key_rotation_deg", p.key_rotation_deg, 0.0, 180.0,
          "Rotation from all keyframes at which a new one is taken [deg].");
  }
};

}  // namespace facetloc
