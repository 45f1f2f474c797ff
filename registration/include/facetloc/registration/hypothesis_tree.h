// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/registration/candidate_pairs.h>
#include <facetloc/registration/ekf_pose_update.h>

#include <vector>

namespace facetloc {

/** \brief Best-first search for consistent sets of pairs (METHOD 10.3-10.4). */
struct HypothesisTreeParams {
  int max_expansions = 700;  ///< Kalman updates per local model
  int max_hypotheses = 10;   ///< distinct poses per local model (METHOD_MEASURED 10.3: 10 are enough)
  int max_pairs = 6;         ///< pairs of a hypothesis
  double min_gain = 1.0;     ///< information that a further pair must add [nats]
  double angle_gate = 3.0;  ///< on the difference between the angles of two scene and two model normals [std]
  double complete_rotation_deg = 3.0;   ///< largest orientation std of a complete hypothesis
  double complete_translation = 0.2;    ///< largest position std of a complete hypothesis [m]
  double duplicate_rotation_deg = 1.0;  ///< unrefined poses nearer than this and ...
  double duplicate_translation = 0.05;  ///< ... this are one hypothesis [m]

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& field) {
    field("max_expansions", p.max_expansions, 1, 1000000, "Limit of Kalman updates per local model.");
    field("max_model_hypotheses", p.max_hypotheses, 1, 10000,
          "Limit of distinct hypotheses per local model.");
    field("max_pairs", p.max_pairs, 1, 16, "Limit of segment pairs in the search for a hypothesis.");
    field("min_gain", p.min_gain, 0.0, 100.0, "Information that a further pair must add [nats].");
    field("angle_gate", p.angle_gate, 0.1, 1e6,
          "Largest difference between the angles of two scene and two model normals [standard deviations].");
    field("complete_rotation_deg", p.complete_rotation_deg, 0.01, 90.0,
          "Largest orientation uncertainty of a complete hypothesis, standard deviation [deg].");
    field("complete_translation", p.complete_translation, 0.001, 100.0,
          "Largest position uncertainty of a complete hypothesis, standard deviation [m].");
    field("duplicate_rotation_deg", p.duplicate_rotation_deg, 0.0, 90.0,
          "Hypotheses of a model nearer than this angle and duplicate_translation are one [deg].");
    field("duplicate_translation", p.duplicate_translation, 0.0, 10.0,
          "Hypotheses of a model nearer than this distance and duplicate_rotation_deg are one [m].");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief What measurements alone say of a pose, without its prior: standard deviations along the principal
 * directions of P_meas = (Lambda + weak prior)^-1, ascending. */
struct Observability {
  Eigen::Vector3d rotation_std = Eigen::Vector3d::Constant(1e6);     ///< [rad]
  Eigen::Matrix3d rotations = Eigen::Matrix3d::Identity();           ///< columns: axes of those rotations
  Eigen::Vector3d translation_std = Eigen::Vector3d::Constant(1e6);  ///< [m]
  Eigen::Matrix3d directions = Eigen::Matrix3d::Identity();  ///< columns: directions of those translations

  bool complete(double max_rotation_std, double max_translation_std) const {
    return rotation_std[2] <= max_rotation_std && translation_std[2] <= max_translation_std;
  }
  /** \brief Orientation and two translations are fixed, the third is not. */
  bool oneTranslationFree(double max_rotation_std, double max_translation_std) const {
    return rotation_std[2] <= max_rotation_std && translation_std[1] <= max_translation_std &&
           translation_std[2] > max_translation_std;
  }
};
/** \brief The weak prior of METHOD 10.4, 30 deg and 10 m on every axis, only makes the sum invertible. */
Observability observability(const Matrix6d& information);

/** \brief A set of mutually consistent pairs and the pose that they give. */
struct PoseNode {
  PoseWithCovariance pose;
  Matrix6d information = Matrix6d::Zero();  ///< of the pairs alone
  std::vector<SegmentPair> pairs;
  Eigen::Vector3d free_direction =
      Eigen::Vector3d::Zero();  ///< unit vector in model axes, for incomplete nodes
};

/** \brief Poses without duplicates, in the order found. */
struct FoundPoses {
  std::vector<PoseNode> complete;    ///< all six degrees of freedom are fixed
  std::vector<PoseNode> incomplete;  ///< exactly one translation is free
};

/** \brief What the search of one local model found. */
struct TreeSearchResult {
  FoundPoses by_pairs;
  FoundPoses with_known;  ///< what pairs fix only together with what is known without them
  int expansions = 0;
};

/** \brief Searches the index-increasing sequences of candidate pairs in which no segment occurs twice; each
 * set of pairs is visited at most once, the ones of the best-ranked pairs first. Without the limits the
 * search is exhaustive over all gate-consistent sets.
 * \param known information about the pose that needs no pair, such as floorInformation() */
TreeSearchResult searchHypotheses(const std::vector<Segment>& scene, const std::vector<Segment>& model,
                                  const std::vector<SegmentPair>& candidates, const PoseWithCovariance& prior,
                                  const MatchingParams& matching, const EkfParams& ekf,
                                  const HypothesisTreeParams& params,
                                  const Matrix6d& known = Matrix6d::Zero());

}  // namespace facetloc
