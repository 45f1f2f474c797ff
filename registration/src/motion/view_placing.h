// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "nearby/view_alignment.h"
#include "pairs/view_registration.h"

#include <facetloc/features/local_model.h>

#include <optional>

namespace facetloc::internal {

/** \brief Where a view is beside another one, by what the two show. */
struct PlacedView {
  Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();  ///< a = the other view, b = this one
  Matrix6d information = Matrix6d::Zero();  ///< of the two views alone: zero along what they do not tell
  double agreement = 0;  ///< of the depth pixels that agree or contradict, those that agree
  double overlap = 0;    ///< share of the depth pixels that agree or contradict
};

/** \brief Places a view beside another one from several starts and takes the place that depth likes best, for
 * an alignment that starts far from the truth may end elsewhere and look sure there. Never changes;
 * thread-safe. */
class ViewPlacing {
public:
  ViewPlacing();

  /** \param prior T_a_b, positive definite \param search also looks for all places within the prior that the
   * planes in common allow (ViewRegistration)
   * \return nothing if the views have too little in common to say anything. */
  std::optional<PlacedView> place(const View& view, const View& other, const PoseWithCovariance& prior,
                                  bool search) const;

private:
  std::vector<Eigen::Isometry3d> starts(const View& view, const View& other, const PoseWithCovariance& prior,
                                        bool search) const;

  ViewAlignmentParams alignment_;
  DepthComparison comparison_;
  ViewRegistration registration_;
};

}  // namespace facetloc::internal
