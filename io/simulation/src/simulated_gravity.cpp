// SPDX-License-Identifier: BSD-3-Clause
#include "random.h"

#include <facetloc/simulation/simulated_gravity.h>

#include <algorithm>

namespace facetloc {

std::vector<Gravity> simulateGravity(const std::vector<Eigen::Isometry3d>& T_w_c, double std,
                                     std::uint64_t seed) {
  constexpr std::uint64_t kErrors = 2;  // a purpose of its own: the seed may be the drive's
  constexpr double kLeastStd = 0.001 * kDegree;
  Random random(derivedSeed(seed, kErrors));
  std::vector<Gravity> found;
  for (const Eigen::Isometry3d& T : T_w_c) {
    const Eigen::Vector3d error(std * random.normal(), std * random.normal(), 0);
    const Eigen::Vector3d down = T.linear().transpose() * (expSO3(error) * -Eigen::Vector3d::UnitZ());
    found.push_back(gravityAlong(down, std::max(kLeastStd, std)));
  }
  return found;
}

}  // namespace facetloc
