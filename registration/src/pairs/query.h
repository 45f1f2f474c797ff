// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>
#include <facetloc/features/pose.h>

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

}  // namespace facetloc::internal
