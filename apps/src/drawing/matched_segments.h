// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>
#include <facetloc/registration/hypothesis.h>

#include <vector>

namespace facetloc {

/** \brief Which segments agree at a pose: for each scene segment the model segment that fits best, if any
 * passes the gates of the search with as much slack as the score of a hypothesis has; in the order of the
 * scene segments. Several of these may match one model segment. */
std::vector<SegmentPair> matchedSegments(const View& scene, const View& model,
                                         const Eigen::Isometry3d& T_m_c);

}  // namespace facetloc
