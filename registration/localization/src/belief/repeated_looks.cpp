// SPDX-License-Identifier: BSD-3-Clause
#include "belief/repeated_looks.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace facetloc::internal {

void RepeatedLooks::discount(LocalMap& surroundings) const {
  constexpr double kMost = 0.9999;  // correlation: keeps covariances finite while the camera stands
  for (std::size_t i = 0; i < surroundings.segments.size(); ++i) {
    const LocalMap::Origin& origin = surroundings.origins[i];
    const auto found = correlation_.find({origin.view, origin.segment});
    if (found == correlation_.end()) continue;
    const double rho = std::min(found->second, kMost);
    surroundings.segments[i].Sigma_q *= (1 + rho) / (1 - rho);
  }
}

void RepeatedLooks::add(const std::vector<SegmentPair>& pairs, const LocalMap& surroundings) {
  for (const SegmentPair& p : pairs) {
    const LocalMap::Origin& origin = surroundings.origins[p.model];
    correlation_[{origin.view, origin.segment}] = 1;
  }
}

void RepeatedLooks::move(const Eigen::Isometry3d& T_a_b) {
  constexpr double kForgotten = 0.01;
  const double kept =
      std::exp(-T_a_b.translation().norm() / kDistance - rotationAngle(T_a_b.linear()) / kRotation);
  for (auto look = correlation_.begin(); look != correlation_.end();) {
    look->second *= kept;
    look = look->second < kForgotten ? correlation_.erase(look) : std::next(look);
  }
}

}  // namespace facetloc::internal
