// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>
#include <facetloc/features/params.h>
#include <facetloc/registration/depth_consistency.h>
#include <facetloc/registration/hypothesis.h>

#include <vector>

namespace facetloc {

/** \brief What segments say for a hypothesis (METHOD 11, METHOD_MEASURED 11.4). */
struct ConsensusParams {
  bool surface_score =
      false;  ///< the segment-overlap score of METHOD 11.1 alone: no depth terms, probabilities mean nothing
  double match_probability = 0.9;  ///< pi_m: that a visible, static surface is in the model
  double slope_slack_deg = 1.0;    ///< s_o
  double offset_slack = 0.02;      ///< r_o [m]
  double max_offset = 6.0;         ///< rho_max of the chance density [m]
  double parallel_weight = 0.5;  ///< mu: how much a direction already seen explains a further parallel plane
  double coplanar_weight = 0.8;  ///< of these: another part of the very plane; 0 = METHOD 11.4 (2)
  double free_space_weight = 6.9;   ///< w of the free-space term, in each direction [nats]; 0 = none
  double free_space_share = 0.005;  ///< c_0, a share of contradicting pixels that says little

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& field) {
    field("surface_score", p.surface_score, false, true,
          "Score by segment overlap instead of the log likelihood ratio.");
    field("match_probability", p.match_probability, 0.01, 0.999,
          "Probability that a visible surface is in the model.");
    field("slope_slack_deg", p.slope_slack_deg, 0.0, 45.0,
          "Slack of slopes in the score, standard deviation [deg].");
    field("offset_slack", p.offset_slack, 0.0, 10.0,
          "Slack of offsets in the score, standard deviation [m].");
    field("max_offset", p.max_offset, 0.1, 1e3, "Range of offsets of a chance plane [m].");
    field("parallel_weight", p.parallel_weight, 0.0, 0.99,
          "Share of chance planes that are parallel to one already seen.");
    field("coplanar_weight", p.coplanar_weight, 0.0, 0.99,
          "Share of those that are another part of it; 0 = each part of a wall is evidence of its own.");
    field(
        "free_space_weight", p.free_space_weight, 0.0, 1e4,
        "Weight of depth pixels that contradict a pose, in each direction [nats]; 0 switches the term off.");
    field("free_space_share", p.free_space_share, 1e-6, 1.0,
          "Share of contradicting depth pixels that says little.");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief Points spread evenly over the outline of a segment, in its camera's frame. */
std::vector<Eigen::Vector3d> samplePoints(const Segment& segment);

/** \brief The samples of every segment of a scene, made once and used for every hypothesis. */
std::vector<std::vector<Eigen::Vector3d>> samplePoints(const View& scene);

/** \brief Log likelihood ratio of the scene's segments under a hypothesis against chance (METHOD 11.4
 * (1)-(4)) [nats]. Visibility comes from the model's depth picture; without one every sample counts as
 * visible. */
double logLikelihoodRatio(const View& scene, const std::vector<std::vector<Eigen::Vector3d>>& samples,
                          const View& model, const PoseWithCovariance& T_m_c,
                          const DepthComparison& comparison, const ConsensusParams& params);

/** \brief What the contradicting pixels among those compared say against a pose: -w ln(1 + c / c_0) [nats], c
 * being their share.
 *
 * The term is not linear in c (as METHOD_MEASURED 11.4 (5) has it) since pixels do not contradict one by one:
 * what has moved takes a whole region with it. The share of changed pixels in a true view is mostly tiny and
 * now and then large, with a tail like a power of c; so is the evidence against the pose. */
double freeSpaceTerm(const DepthAgreement& compared, const ConsensusParams& params);

/** \brief Segment-overlap score (METHOD 11.1), the paper's consensus measure as far as is known. */
double surfaceMatchingScore(const std::vector<Segment>& scene, const std::vector<Segment>& model,
                            const PoseWithCovariance& T_m_c, const MatchingParams& matching);

}  // namespace facetloc
