// SPDX-License-Identifier: BSD-3-Clause
#include "belief/place_belief.h"

#include "shared/in_parallel.h"
#include "shared/pose_fusion.h"

#include <facetloc/features/chi_square.h>

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace facetloc::internal {
namespace {

constexpr double kGate = chiSquareQuantile(6, 0.99);
constexpr double kForgotten = 1e-4;   // odds that no later view makes up for
constexpr std::size_t kMostNew = 8;   // places that a search brings up
constexpr double kHopeless = 1e-5;    // probability in a search
constexpr double kMostOfOneLook = 5;  // that one look adds or takes away [nats]
constexpr double kLeast = 1e-3;       // [m, rad]

// Is a place that a search has found one where the camera is thought to be?
bool isThere(const BelievedPlace& place, const Hypothesis& found) {
  if (place.part != found.part) return false;
  if (kSameAnswer.joins(place.T_w_c.T, *found.T_w_c)) return true;
  return squaredMahalanobis(place.T_w_c, *found.T_w_c) < kGate;
}

double bounded(double log_odds) { return std::clamp(log_odds, -kMostOfOneLook, kMostOfOneLook); }

}  // namespace

PlaceBelief::PlaceBelief(std::shared_ptr<const Map> map, const GlobalLocalizationParams& localization,
                         const SequenceParams& params)
    : map_(std::move(map)),
      params_(checked(params)),
      calibration_(localization.calibration.sequence),
      prior_(-localization.probability.priorLogOdds()),
      ranking_(map_,
               [&] {
                 GlobalLocalizationParams without_prior = localization;
                 without_prior.probability.map_incomplete = 0.5;  // it counts once, not with every look
                 return without_prior;
               }()),
      has_odds_(!localization.score.by_overlap) {}

void PlaceBelief::clear() {
  places_.clear();
  kept_.clear();
  way_ = turn_ = 0;
  looks_ = 0;
}

void PlaceBelief::move(const PoseWithCovariance& T_a_b) {
  for (BelievedPlace& place : places_) {
    place.T_w_c = place.T_w_c * T_a_b;
    place.match.pairs.clear();  // they were of another view
  }
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
    return place.part == part && kSameAnswer.joins(place.T_w_c.T, T_w_c.T);
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

PoseWithCovariance PlaceBelief::poseOf(const Hypothesis& h) const {
  return *map_->models[h.model].T_w_m * h.T_m_c;
}

// What a view says of a place that was known before it.
double PlaceBelief::oddsOfKnown(const View& view, const Hypothesis& h) const {
  const ScoreOdds odds = ranking_.oddsOfKnown(ranking_.mayHaveEvidence(view), calibration_.lookalike_weight,
                                              calibration_.lookalike_share_of_place, h);
  return bounded(odds(h.score));
}

// What the kept looks say of a place that they were not held against.
double PlaceBelief::historyOf(const Hypothesis& place) const {
  double sum = 0;
  for (const Look& look : kept_) {
    const auto seen = ranking_.at(Query(*look.view), place.part, poseOf(place) * look.T_c_l);
    if (seen) sum += look.weight * oddsOfKnown(*look.view, *seen);
  }
  return sum;
}

// Those that are a known place take the place of what was seen there, if they score better; returns the
// others that are likely enough.
std::vector<Hypothesis> PlaceBelief::sortFound(const Localization& found,
                                               std::vector<std::optional<Hypothesis>>& seen) const {
  std::vector<Hypothesis> fresh;
  for (const Hypothesis& h : found.hypotheses) {
    if (!h.T_w_c || !map_->models[h.model].T_w_m) continue;
    const auto known = std::find_if(places_.begin(), places_.end(),
                                    [&h](const BelievedPlace& place) { return isThere(place, h); });
    if (known == places_.end()) {
      if (h.probability > kHopeless && fresh.size() < kMostNew) fresh.push_back(h);
      continue;
    }
    std::optional<Hypothesis>& there = seen[known - places_.begin()];
    if (!there || h.score > there->score) there = h;
  }
  return fresh;
}

double PlaceBelief::look(std::shared_ptr<const View> view, const Localization* found, bool independent) {
  if (!has_odds_) return 0;
  const double independence = looks_ == 0 || independent
                                  ? 1
                                  : 1 - std::exp(-motionSince(calibration_.independent_distance,
                                                              calibration_.independent_rotation_deg));
  const Query query(*view);
  std::vector<std::optional<Hypothesis>> seen(places_.size());
  forEachInParallel(static_cast<int>(places_.size()), threads_,
                    [&](int i) { seen[i] = ranking_.at(query, places_[i].part, places_[i].T_w_c); });
  std::vector<Hypothesis> fresh;
  if (found) fresh = sortFound(*found, seen);

  double of_best = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (!seen[i]) continue;
    const double added = independence * oddsOfKnown(*view, *seen[i]);
    if (i == 0) of_best = added;
    update(places_[i], *seen[i], independence, added);
  }
  addFresh(*view, fresh, seen, independence);
  ++looks_;
  way_ = turn_ = 0;
  PoseWithCovariance here;
  here.P = kLeast * kLeast * Matrix6d::Identity();
  kept_.push_back({std::move(view), here, independence});
  while (static_cast<int>(kept_.size()) > params_.kept_looks) kept_.pop_front();
  normalize();
  return of_best;
}

void PlaceBelief::update(BelievedPlace& place, const Hypothesis& seen, double weight, double log_odds) const {
  place.log_odds += log_odds;
  PoseWithCovariance T_w_c = poseOf(seen);
  T_w_c.P = discounted(place.T_w_c.P, T_w_c.P, weight);
  place.T_w_c = T_w_c;
  place.match = seen;
}

// Places that a search has brought up are the best of many: for this view, they are ranked as it ranks them.
void PlaceBelief::addFresh(const View& view, const std::vector<Hypothesis>& fresh,
                           const std::vector<std::optional<Hypothesis>>& seen, double weight) {
  std::vector<Hypothesis> list = fresh;
  for (const auto& h : seen)
    if (h) list.push_back(*h);
  std::stable_sort(list.begin(), list.end(),
                   [](const Hypothesis& a, const Hypothesis& b) { return a.score > b.score; });
  const ScoreOdds odds = ranking_.odds(ranking_.mayHaveEvidence(view), list);
  std::vector<double> before(fresh.size());
  forEachInParallel(static_cast<int>(fresh.size()), threads_,
                    [&](int i) { before[i] = historyOf(fresh[i]); });
  for (std::size_t i = 0; i < fresh.size(); ++i) {
    BelievedPlace place;
    place.T_w_c = poseOf(fresh[i]);
    place.part = fresh[i].part;
    place.log_odds = prior_ + before[i] + weight * bounded(odds(fresh[i].score));
    place.match = fresh[i];
    places_.push_back(std::move(place));
  }
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
      return other.part == place.part && kSameAnswer.joins(other.T_w_c.T, place.T_w_c.T);
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
