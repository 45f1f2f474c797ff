// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/map_metadata.h>
#include <facetloc/features/pose.h>

#include <memory>
#include <vector>

namespace facetloc::internal {

/** \brief A view of a map, aligned anew with those around it. */
struct RealignedView {
  Vector6d error;        ///< perturbation from the pose found to the one in the map
  Matrix6d information;  ///< all compared pixels as independent measurements, without the prior
};

/** \brief Aligns views of a map with their surroundings by all pixels, from where they are (METHOD 2.3). */
std::vector<RealignedView> realignedViews(const std::shared_ptr<const Map>& map, int threads);

/** \brief The likeliest errors of such views; of few, drawn towards the usual. */
ConsideredErrors consideredErrors(const std::vector<RealignedView>& views);

}  // namespace facetloc::internal
