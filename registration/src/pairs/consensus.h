// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "depth/depth_consistency.h"

#include <facetloc/features/local_model.h>
#include <facetloc/features/pose.h>
#include <facetloc/registration/hypothesis.h>
#include <facetloc/registration/registration_params.h>

#include <vector>

namespace facetloc::internal {

/** \brief A view that is looked for, with all that is the same for every local model it is registered with.
 */
struct Query {
  /** \brief Makes the samples. \param view must outlive the query */
  explicit Query(const View& view, const PoseWithCovariance& prior = {},
                 const Matrix6d& known = Matrix6d::Zero());

  const View& view;
  std::vector<std::vector<Eigen::Vector3d>> samples;  ///< samplePoints() of each of its segments
  PoseWithCovariance prior;                           ///< T_m_c before anything was seen
  Matrix6d known;  ///< information about T_m_c that no view needs to tell, such as floorInformation()
};

/** \brief Points spread evenly over the outline of a segment, in its camera's frame. */
std::vector<Eigen::Vector3d> samplePoints(const Segment& segment);

/** \brief Log likelihood ratio of the scene's segments under a hypothesis against chance (METHOD
 * 10.1-10.3) [nats]. Visibility comes from the model's depth picture; without one every sample counts as
 * visible. */
double logLikelihoodRatio(const Query& query, const View& model, const PoseWithCovariance& T_m_c,
                          const DepthComparison& comparison, const ScoreCalibration& params);

/** \brief Segment-overlap score (METHOD 10.5), the paper's consensus measure as far as is known. */
double surfaceMatchingScore(const std::vector<Segment>& scene, const std::vector<Segment>& model,
                            const PoseWithCovariance& T_m_c, const MatchingParams& matching);

/** \brief How a hypothesis is scored by its own local model: by the log likelihood ratio and the free-space
 * term, or, as in the paper, by the overlap of segments. Never changes; thread-safe. */
class HypothesisScore {
public:
  HypothesisScore(const ViewRegistrationParams& params, const DepthComparison& comparison)
      : by_overlap_(params.score.by_overlap),
        matching_(params.matching),
        params_(params.calibration.score),
        comparison_(comparison) {}

  /** \brief Sets consensus, free_space and score. \param columns of the grid of pixels that are compared */
  void score(const Query& query, const View& model, int columns, Hypothesis& h) const;
  /** \brief Is it a log likelihood ratio, to which evidence adds and from which probabilities follow? */
  bool inNats() const { return !by_overlap_; }

private:
  bool by_overlap_;
  MatchingParams matching_;
  ScoreCalibration params_;
  DepthComparison comparison_;
};

/** \brief The highest score first. */
void sortByScore(std::vector<Hypothesis>& hypotheses);

}  // namespace facetloc::internal
