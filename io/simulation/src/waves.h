// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "random.h"

#include <facetloc/simulation/simulated_place.h>

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace facetloc {

/** \brief A smooth random function of a place, of unit variance: a sum of plane waves of all directions. */
class Waves {
public:
  /** \param shortest, longest their wavelengths [m] */
  Waves(double shortest, double longest, Random random) {
    constexpr double kTurn = 2 * EIGEN_PI;
    for (Wave& wave : waves_) {
      for (double& along : wave.vector) along = random.normal();
      wave.vector *= kTurn / random.uniform(shortest, longest) / wave.vector.norm();
      wave.phase = random.uniform(0, kTurn);
    }
  }
  double at(const Eigen::Vector3d& place) const {
    double sum = 0;
    for (const Wave& wave : waves_) sum += std::sin(wave.vector.dot(place) + wave.phase);
    return std::sqrt(2.0 / static_cast<double>(waves_.size())) * sum;
  }

private:
  struct Wave {
    Eigen::Vector3d vector = Eigen::Vector3d::Zero();  // wave vector [rad/m]
    double phase = 0;
  };
  std::array<Wave, 8> waves_;
};

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
