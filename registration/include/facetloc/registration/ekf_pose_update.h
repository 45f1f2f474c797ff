// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/params.h>
#include <facetloc/registration/plane_measurement.h>

namespace facetloc {

/** \brief The iterated Extended Kalman Filter for one pair of segments (METHOD 8). */
struct EkfParams {
  int iterations = 20;      ///< 1 = the paper's EKF
  double gate = 11.345;     ///< on the post-fit cost, chi2(3) at 99 %
  double min_cosine = 0.5;  ///< between the normals of a pair, before each linearisation

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& field) {
    field("ekf_iterations", p.iterations, 1, 100, "Iterations of the Kalman update; 1 is the paper's EKF.");
    field("ekf_gate", p.gate, 0.1, 1e6,
          "Largest post-fit cost of a pair, chi-square of 3 degrees of freedom.");
    field("ekf_min_cosine", p.min_cosine, 0.0, 1.0,
          "Smallest cosine between the normals of a pair at the current pose.");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief The result of an update. */
struct EkfUpdate {
  bool accepted = false;    ///< converged and within the gate
  PoseWithCovariance pose;  ///< posterior
  double cost = 0;          ///< post-fit MAP cost, ~ chi2(3) under a correct pair (METHOD 8.2)
  double gain = 0;          ///< information gain [nats] (METHOD 8.3)
  Matrix6d information;     ///< H^T W^-1 H at the posterior: what the pair alone tells
};

/** \brief Corrects a pose by one pair of segments: 0 = h(w, q, q') as an implicit measurement, re-linearised
 * about its own solution; Joseph form; covariance reset into the tangent space of the new mean. */
EkfUpdate ekfPoseUpdate(const Segment& scene, const Segment& model, const PoseWithCovariance& prior,
                        const EkfParams& params = {});

}  // namespace facetloc
