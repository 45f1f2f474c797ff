// SPDX-License-Identifier: BSD-3-Clause
#include "tracking/likely_places.h"

#include <algorithm>

namespace facetloc::internal {
namespace {

constexpr double kSameTranslation = 0.2, kSameRotation = 3;  // [m, deg]
constexpr double kForgotten = 1e-6;                          // probability that no later view makes up for
constexpr double kAlike = 1.0 / 3;  // of two views that both have a wrong list; 1 / models if independent

double rest(const std::vector<LikelyPlace>& places) {
  double sum = 0;
  for (const LikelyPlace& p : places) sum += p.probability;
  return std::max(1 - sum, 0.0);
}

}  // namespace

std::vector<LikelyPlace> placesOfBoth(const std::vector<LikelyPlace>& before,
                                      const std::vector<LikelyPlace>& now, int models) {
  const double rest_before = rest(before), rest_now = rest(now);
  std::vector<LikelyPlace> out;
  std::vector<char> listed(before.size(), 0);  // in both
  for (const LikelyPlace& place : now) {
    double probability = rest_before / models;
    for (std::size_t i = 0; i < before.size(); ++i) {
      if (before[i].part != place.part ||
          !isNear(before[i].T_w_c.T, place.T_w_c.T, kSameTranslation, kSameRotation))
        continue;
      listed[i] = 1;
      probability = std::max(probability, before[i].probability);
    }
    out.push_back({place.T_w_c, place.probability * probability, place.part});
  }
  for (std::size_t i = 0; i < before.size(); ++i)
    if (!listed[i])
      out.push_back({before[i].T_w_c, before[i].probability * rest_now / models, before[i].part});
  double sum = kAlike * rest_before * rest_now;
  for (const LikelyPlace& p : out) sum += p.probability;
  for (LikelyPlace& p : out) p.probability = sum > 0 ? p.probability / sum : 0;
  const auto isForgotten = [](const LikelyPlace& p) { return p.probability < kForgotten; };
  out.erase(std::remove_if(out.begin(), out.end(), isForgotten), out.end());
  return out;
}

}  // namespace facetloc::internal
