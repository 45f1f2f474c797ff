// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "waves.h"

#include <facetloc/simulation/simulated_place.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace facetloc {

/** \brief Where a camera sees surfaces that are bent. */
class BentSurfaces {
public:
  BentSurfaces(const SurfaceBending& bending, const Eigen::Isometry3d& T_w_c)
      : bending_(bending), T_w_c_(T_w_c) {}

  /** \brief The depth at which a ray meets a surface (hits.h) that it would meet at the depth z if that was
   * not bent. */
  template <class Surface>
  double depth(const Surface& surface, const Eigen::Vector3d& ray, double z) {
    if (!(bending_.std > 0)) return z;
    constexpr double kGrazing = 0.1;  // cosine below which a ray would glide along the surface
    const Eigen::Vector3d p = z * ray;
    const double towards = surface.normalAt(p).dot(ray);
    const double moved = bending_.std * waves(surface.label).at(T_w_c_ * p);
    return z + moved / std::copysign(std::max(std::abs(towards), kGrazing), towards);
  }

private:
  const Waves& waves(std::uint16_t label) {
    const auto known = waves_.find(label);
    if (known != waves_.end()) return known->second;
    constexpr double kLongest = 3;  // wavelength, in terms of the shortest
    const Random random(derivedSeed(bending_.seed, label));
    return waves_.emplace(label, Waves(bending_.length, kLongest * bending_.length, random)).first->second;
  }

  SurfaceBending bending_;
  Eigen::Isometry3d T_w_c_;
  std::map<std::uint16_t, Waves> waves_;
};

}  // namespace facetloc
