// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/registration/repeated_looks.h>

#include <cmath>

namespace facetloc {

void RepeatedLooks::discount(Surroundings& surroundings) const {
  for (std::size_t i = 0; i < surroundings.segments.size(); ++i) {
    const Surroundings::Origin& origin = surroundings.origins[i];
    const auto found = looks_.find({origin.view, origin.segment});
    if (found == looks_.end()) continue;
    const double n = 1 + found->second;
    surroundings.segments[i].Sigma_q *= n * (n + 1) - 1;
  }
}

void RepeatedLooks::add(const std::vector<SegmentPair>& pairs, const Surroundings& surroundings) {
  for (const SegmentPair& p : pairs) {
    const Surroundings::Origin& origin = surroundings.origins[p.model];
    looks_[{origin.view, origin.segment}] += 1;
  }
}

void RepeatedLooks::move(const Eigen::Isometry3d& T_a_b) {
  constexpr double kForgotten = 0.01;  // looks
  const double kept =
      std::exp(-T_a_b.translation().norm() / kDistance - rotationAngle(T_a_b.linear()) / kRotation);
  for (auto look = looks_.begin(); look != looks_.end();) {
    look->second *= kept;
    look = look->second < kForgotten ? looks_.erase(look) : std::next(look);
  }
}

}  // namespace facetloc
