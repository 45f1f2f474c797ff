// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "random.h"

#include <Eigen/Core>

#include <array>
#include <cmath>

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

}  // namespace facetloc
