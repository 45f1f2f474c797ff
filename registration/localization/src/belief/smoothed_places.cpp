// SPDX-License-Identifier: BSD-3-Clause
#include "belief/place_belief.h"
#include "poses/pose_fusion.h"
#include "ranking/place_ranking.h"

#include <facetloc/features/pose.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace facetloc::internal {
namespace {

constexpr double kGate = chiSquareQuantile(6, 0.99);
constexpr double kNowhereLeft = 1e-9;  // rounding error of the probability of nowhere

struct Place {
  Hypothesis match;
  PoseWithCovariance T_w_c;
  double log_odds;  // against nowhere
};

Eigen::Isometry3d modelPose(const Hypothesis& h) { return *h.T_w_c * h.T_m_c.T.inverse(); }

std::vector<Place> placesOf(const Localization& answer) {
  std::vector<Place> places;
  const double nowhere = std::max(answer.not_in_map.value_or(1), kNowhereLeft);
  for (const Hypothesis& h : answer.hypotheses)
    places.push_back({h, modelPose(h) * h.T_m_c, std::log(std::max(h.probability, kNowhereLeft) / nowhere)});
  return places;
}

bool isSamePlace(const Place& a, const Place& b) {
  if (a.match.part != b.match.part) return false;
  if (kSameAnswer.joins(a.T_w_c.T, b.T_w_c.T)) return true;
  return squaredMahalanobis(a.T_w_c, b.T_w_c) < kGate;
}

// Log odds of a place that is not in a list: no likelier than the last of it, nor than an unlisted
// place.
double oddsOfUnlisted(const std::vector<Place>& list) {
  double least = 0;
  for (const Place& place : list) least = std::min(least, place.log_odds);
  return least;
}

}  // namespace

Localization smoothedPlaces(const Localization& until_now, const Localization& from_next,
                            const PoseWithCovariance& T_now_next, double prior) {
  std::vector<Place> places = placesOf(until_now), later = placesOf(from_next);
  const double unlisted = oddsOfUnlisted(places), unlisted_later = oddsOfUnlisted(later);
  const PoseWithCovariance T_next_now = inverse(T_now_next);
  for (Place& place : later) {
    place.T_w_c = place.T_w_c * T_next_now;
    place.match.pairs.clear();  // they are of another view
  }
  std::vector<char> is_taken(later.size(), 0);
  for (Place& place : places) {
    std::size_t i = 0;
    while (i < later.size() && (is_taken[i] || !isSamePlace(place, later[i]))) ++i;
    const bool is_known = i < later.size();
    place.log_odds += (is_known ? later[i].log_odds : unlisted_later) - prior;
    if (!is_known) continue;
    is_taken[i] = 1;
    place.T_w_c = covarianceIntersection(place.T_w_c, later[i].T_w_c);
  }
  for (std::size_t i = 0; i < later.size(); ++i) {
    if (is_taken[i]) continue;
    later[i].log_odds += unlisted - prior;
    places.push_back(std::move(later[i]));
  }
  std::stable_sort(places.begin(), places.end(),
                   [](const Place& a, const Place& b) { return a.log_odds > b.log_odds; });
  double sum = 1;
  for (const Place& place : places) sum += std::exp(place.log_odds);

  Localization out;
  out.not_in_map = 1 / sum;
  out.looks = until_now.looks + from_next.looks - 1;  // views next to each other tell the same
  out.T_before_now = until_now.T_before_now;
  for (Place& place : places) {
    Hypothesis h = std::move(place.match);
    const Eigen::Isometry3d T_w_m = modelPose(h);
    h.T_w_c = place.T_w_c.T;
    h.T_m_c = T_w_m.inverse() * place.T_w_c;
    h.probability = std::exp(place.log_odds) / sum;
    out.hypotheses.push_back(std::move(h));
  }
  return out;
}

}  // namespace facetloc::internal
