// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "nearby/view_alignment.h"
#include "pairs/view_registration.h"

#include <facetloc/features/local_model.h>

#include <optional>
#include <vector>

namespace facetloc::internal {

/** \brief A pose of a view relative to another one at which the two agree: a minimum of their cost. */
struct PlacedView {
  Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();  ///< a = the other view, b = this one
  Matrix6d information =
      Matrix6d::Zero();  ///< information of the two views alone: zero along motions that they leave free
  double agreement = 0;  ///< share of agreeing pixels among those that agree or contradict
  double overlap = 0;    ///< share of the depth pixels that agree or contradict
  double log_likelihood =
      0;           ///< log likelihood of the pixels and the prior, comparable among poses of two views [nats]
  int judged = 0;  ///< pixels that the two pictures compare
};

/** \brief Finds the poses of a view relative to another one by several starts and by depth, for an alignment
 * that starts far from the truth may end elsewhere and look sure there. Never changes; thread-safe. */
class ViewPlacing {
public:
  ViewPlacing();

  /** \brief The likeliest pose.
   * \param prior T_a_b, positive definite \param search also looks for all places within the prior that the
   * planes in common allow (ViewRegistration)
   * \return nothing if the views have too little in common to say anything. */
  std::optional<PlacedView> place(const View& view, const View& other, const PoseWithCovariance& prior,
                                  bool search) const;

  /** \brief All poses that the views and the prior leave open, the likeliest first: the next door along a
   * corridor looks the same. In addition to the starts of place(), the cost is walked along each axis as far
   * as the prior reaches. The information of a pose comes from the cost itself, not from its derivatives
   * alone (mapping/METHOD 1.4). Empty if the views have too little in common to say anything. */
  std::vector<PlacedView> modes(const View& view, const View& other, const PoseWithCovariance& prior) const;

private:
  std::vector<Eigen::Isometry3d> starts(const View& view, const View& other, const PoseWithCovariance& prior,
                                        bool search) const;

  ViewAlignmentParams alignment_;
  DepthComparison comparison_;
  ViewRegistration registration_;
};

}  // namespace facetloc::internal
