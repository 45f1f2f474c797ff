// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "depth/depth_consistency.h"
#include "pairs/query.h"

#include <facetloc/features/local_model.h>
#include <facetloc/registration/hypothesis.h>
#include <facetloc/registration/registration_params.h>

#include <memory>
#include <vector>

namespace facetloc::internal {

/** \brief Points spread evenly over the outline of a segment, in its camera's frame. */
std::vector<Eigen::Vector3d> samplePoints(const Segment& segment);

/** \brief Log likelihood ratio of the scene's segments under a hypothesis against chance (METHOD
 * 10.1-10.3) [nats]. Visibility comes from the model's depth picture; without one every sample counts as
 * visible. */
double logLikelihoodRatio(const Query& query, const View& model, const PoseWithCovariance& T_m_c,
                          const DepthComparison& comparison, const ScoreCalibration& params);

/** \brief Evidence of contradicting pixels against a pose: -w ln(1 + c / c_0) [nats], where c
 * is their share among those compared.
 *
 * The term is not linear in c, since pixels do not contradict one by one:
 * a moved object covers a whole region. The share of changed pixels in a true view is mostly tiny and
 * now and then large, with a tail like a power of c; so is the evidence against the pose. */
double freeSpaceTerm(const DepthAgreement& compared, const ScoreCalibration& params);

/** \brief Segment-overlap score (METHOD 10.5), the paper's consensus measure as far as is known. */
double surfaceMatchingScore(const std::vector<Segment>& scene, const std::vector<Segment>& model,
                            const PoseWithCovariance& T_m_c, const MatchingParams& matching);

/** \brief How a hypothesis is scored by its own local model. Never changes; thread-safe. */
class HypothesisScore {
public:
  virtual ~HypothesisScore() = default;
  /** \brief Sets consensus, free_space and score. \param columns of the grid of pixels that are compared */
  virtual void score(const Query& query, const View& model, int columns, Hypothesis& h) const = 0;
  /** \brief Is it a log likelihood ratio, to which evidence adds and from which probabilities follow? */
  virtual bool inNats() const = 0;
};

/** \brief Ours, the log likelihood ratio and the free-space term, or the paper's, the overlap of segments. */
std::unique_ptr<const HypothesisScore> hypothesisScore(const ViewRegistrationParams& params,
                                                       const DepthComparison& comparison);

}  // namespace facetloc::internal
