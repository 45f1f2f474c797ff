// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/params.h>
#include <facetloc/features/pose.h>

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
  void validate() const { checkRanges(*this); }
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
  void validate() const { checkRanges(*this); }
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
  void validate() const { checkRanges(*this); }
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
  void validate() const { checkRanges(*this); }
};

}  // namespace facetloc
