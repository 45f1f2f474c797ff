// SPDX-License-Identifier: BSD-3-Clause
#include "global/place_belief.h"

#include "shared/in_parallel.h"
#include "shared/pose_fusion.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace facetloc::internal {
namespace {

constexpr double kSameTranslation = 0.3, kSameRotation = 5;  // [m, deg]
constexpr double kGate = 16.8;                               // of 99 % in 6 degrees of freedom
constexpr double kForgotten = 1e-4;                          // odds that no later view makes up for
constexpr std::size_t kMostNew = 8;                          // places that a search brings up
constexpr double kHopeless = 1e-5;                           // probability in a search
constexpr double kMostOfOneLook = 5;                         // that one look adds or takes away [nats]
constexpr double kLeast = 1e-3;                              // [m, rad]

// Is a place that a search has found one where the camera is thought to be?
bool isThere(const BelievedPlace& place, const Hypothesis& found) {
  if (place.part != found.part) return false;
  if (isNear(place.T_w_c.T, *found.T_w_c, kSameTranslation, kSameRotation)) return true;
  const Vector6d d = perturbation(place.T_w_c.T, *found.T_w_c);
  return d.dot(place.T_w_c.P.ldlt().solve(d)) < kGate;
}

}  // namespace

PlaceBelief::PlaceBelief(std::shared_ptr<const Map> map, const GlobalLocalizationParams& localization,
                         const SequenceParams& params)
    : map_(std::move(map)),
      params_(checked(params)),
      prior_(
          -std::log(localization.probability.map_incomplete / (1 - localization.probability.map_incomplete))),
      ranking_(map_,
               [&] {
                 GlobalLocalizationParams without_prior = localization;
                 without_prior.probability.map_incomplete = 0.5;  // it counts once, not with every look
                 return without_prior;
               }()),
      has_odds_(!localization.score.by_overlap) {
  const ProbabilityParams& p = localization.probability;
  known_ = {p.slope, (1 - params_.lookalike_weight) * p.least_null_score +
                         params_.lookalike_weight * meanAmbiguity(p, map_->ambiguity)};
}

void PlaceBelief::clear() {
  places_.clear();
  kept_.clear();
  way_ = turn_ = 0;
  looks_ = 0;
}

void PlaceBelief::move(const PoseWithCovariance& T_a_b) {
  for (BelievedPlace& place : places_) place.T_w_c = place.T_w_c * T_a_b;
  const PoseWithCovariance T_b_a = inverse(T_a_b);
  for (Look& look : kept_) look.T_c_l = T_b_a * look.T_c_l;
  way_ += T_a_b.T.translation().norm();
  turn_ += rotationAngle(T_a_b.T.linear());
}

double PlaceBelief::motionSince(double distance, double rotation_deg) const {
  return way_ / distance + turn_ / (rotation_deg * kDegree);
}

bool PlaceBelief::isDue() const {
  return looks_ == 0 || motionSince(params_.look_distance, params_.look_rotation_deg) >= 1;
}

void PlaceBelief::suppose(int part, const PoseWithCovariance& T_w_c) {
  const auto known = std::find_if(places_.begin(), places_.end(), [&](const BelievedPlace& place) {
    return place.part == part && isNear(place.T_w_c.T, T_w_c.T, kSameTranslation, kSameRotation);
  });
  if (known != places_.end()) {
    known->T_w_c = T_w_c;
    return;
  }
  BelievedPlace place;
  place.T_w_c = T_w_c;
  place.part = part;
  place.log_odds = prior_;
  places_.push_back(std::move(place));
}

// What the kept looks say of a place that they did not look at.
double PlaceBelief::historyOf(const Hypothesis& place) const {
  double sum = 0;
  const PoseWithCovariance T_w_c = *map_->models[place.model].T_w_m * place.T_m_c;
  for (const Look& look : kept_) {
    PoseWithCovariance there = T_w_c * look.T_c_l;
    const Query query(*look.view);
    const auto seen = ranking_.at(query, place.part, there);
    if (seen) sum += look.weight * std::clamp(known_(seen->score), -kMostOfOneLook, kMostOfOneLook);
  }
  return sum;
}

double PlaceBelief::look(std::shared_ptr<const View> view, const Localization* found, bool independent) {
  if (!has_odds_) return 0;
  const double weight =
      looks_ == 0 || independent
          ? 1
          : 1 - std::exp(-motionSince(params_.independent_distance, params_.independent_rotation_deg));
  const Query query(*view);
  std::vector<std::optional<Hypothesis>> seen(places_.size());
  forEachInParallel(static_cast<int>(places_.size()), threads_,
                    [&](int i) { seen[i] = ranking_.at(query, places_[i].part, places_[i].T_w_c); });

  std::vector<Hypothesis> list;  // all that is known of this view
  std::vector<Hypothesis> fresh;
  if (found) {
    for (const Hypothesis& h : found->hypotheses) {
      if (!h.T_w_c || !map_->models[h.model].T_w_m) continue;
      bool is_known = false;
      for (std::size_t i = 0; i < places_.size() && !is_known; ++i) {
        if (!isThere(places_[i], h)) continue;
        is_known = true;
        if (!seen[i] || h.score > seen[i]->score) seen[i] = h;
      }
      if (!is_known && h.probability > kHopeless && fresh.size() < kMostNew) fresh.push_back(h);
    }
  }
  for (const auto& h : seen)
    if (h) list.push_back(*h);
  list.insert(list.end(), fresh.begin(), fresh.end());
  std::stable_sort(list.begin(), list.end(),
                   [](const Hypothesis& a, const Hypothesis& b) { return a.score > b.score; });
  const ScoreOdds of_search = ranking_.odds(!view->depth.empty(), list);

  std::vector<double> before(fresh.size());
  forEachInParallel(static_cast<int>(fresh.size()), threads_,
                    [&](int i) { before[i] = historyOf(fresh[i]); });
  const auto ofLook = [weight](const ScoreOdds& odds, const Hypothesis& h) {
    return weight * std::clamp(odds(h.score), -kMostOfOneLook, kMostOfOneLook);
  };
  const double of_best = !seen.empty() && seen.front() ? ofLook(known_, *seen.front()) : 0;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    if (!seen[i]) continue;
    BelievedPlace& place = places_[i];
    place.log_odds += ofLook(known_, *seen[i]);
    PoseWithCovariance T_w_c = *map_->models[seen[i]->model].T_w_m * seen[i]->T_m_c;
    T_w_c.P = discounted(place.T_w_c.P, T_w_c.P, weight);
    place.T_w_c = T_w_c;
    place.match = *seen[i];
  }
  for (std::size_t i = 0; i < fresh.size(); ++i) {
    BelievedPlace place;
    place.T_w_c = *map_->models[fresh[i].model].T_w_m * fresh[i].T_m_c;
    place.part = fresh[i].part;
    place.log_odds = prior_ + before[i] + ofLook(of_search, fresh[i]);
    place.match = fresh[i];
    places_.push_back(std::move(place));
  }
  ++looks_;
  way_ = turn_ = 0;
  PoseWithCovariance here;
  here.P = kLeast * kLeast * Matrix6d::Identity();
  kept_.push_back({std::move(view), here, weight});
  while (static_cast<int>(kept_.size()) > params_.kept_looks) kept_.pop_front();
  normalize();
  return of_best;
}

// One place once; those that are forgotten go; probabilities.
void PlaceBelief::normalize() {
  std::stable_sort(places_.begin(), places_.end(),
                   [](const BelievedPlace& a, const BelievedPlace& b) { return a.log_odds > b.log_odds; });
  std::vector<BelievedPlace> kept;
  const double beyond = places_.empty() ? 0 : std::max(0.0, places_.front().log_odds - params_.most_log_odds);
  for (BelievedPlace& place : places_) {
    place.log_odds -= beyond;
    const bool is_known = std::any_of(kept.begin(), kept.end(), [&](const BelievedPlace& other) {
      return other.part == place.part &&
             isNear(other.T_w_c.T, place.T_w_c.T, kSameTranslation, kSameRotation);
    });
    if (is_known || place.log_odds < std::log(kForgotten)) continue;
    if (static_cast<int>(kept.size()) < params_.max_places) kept.push_back(std::move(place));
  }
  places_ = std::move(kept);
  double sum = 1;
  for (const BelievedPlace& place : places_) sum += std::exp(place.log_odds);
  for (BelievedPlace& place : places_) place.probability = std::exp(place.log_odds) / sum;
}

}  // namespace facetloc::internal
