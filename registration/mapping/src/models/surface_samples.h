// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/mapping/surface.h>

#include <vector>

namespace facetloc::internal {

/** \brief A direction in which a surface is seen, where it is flat. */
struct SurfaceSample {
  Eigen::Vector3f point, normal;  ///< unit normal towards the viewer
  float weight = 0;               ///< share of all that is seen
};

/** \brief The part of a surface that is visible from inside. */
struct SurfaceSamples {
  std::vector<Eigen::Vector3d> positions;  ///< viewpoints of the samples
  std::vector<SurfaceSample> samples;
  double distance = 0;  ///< median of those seen [units of the surface]
};

/** \brief Looks around from positions spread over the bounds, as far as they are in free space that the
 * surface surrounds. \param threads 0 = all cores */
SurfaceSamples samplesFromInside(const Surface& surface, int threads);

}  // namespace facetloc::internal
