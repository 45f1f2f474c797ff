// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "pairs/plane_measurement.h"

#include <facetloc/registration/registration_params.h>

namespace facetloc::internal {

/** \brief The result of an update. */
struct EkfUpdate {
  bool accepted = false;    ///< settled, or taken on trust, and within the gate
  PoseWithCovariance pose;  ///< posterior
  double cost = 0;          ///< post-fit MAP cost, ~ chi2(3) under a correct pair (METHOD 5.2)
  double gain = 0;          ///< information gain [nats] (METHOD 5.3)
  Matrix6d information;     ///< H^T W^-1 H at the posterior: the information of the pair alone
};

/** \brief Corrects a pose by one pair of segments: 0 = h(w, q, q') as an implicit measurement, re-linearised
 * about its own solution until that settles or params.iterations times; Joseph form; covariance reset into
 * the tangent space of the new mean. Up to 8 iterations the gate alone decides on the last state; with more,
 * a pair that does not settle is refused. */
EkfUpdate ekfPoseUpdate(const Segment& scene, const Segment& model, const PoseWithCovariance& prior,
                        const EkfParams& params = {});

}  // namespace facetloc::internal
