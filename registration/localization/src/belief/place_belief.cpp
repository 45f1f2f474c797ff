// SPDX-License-Identifier: BSD-3-Clause
#include "belief/place_belief.h"

#include "poses/pose_fusion.h"
#include "threads/in_parallel.h"

#include <facetloc/features/pose.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

namespace facetloc::internal {
namespace {

constexpr double kGate = chiSquareQuantile(6, 0.99);
constexpr double kForgotten = 1e-4;          // odds that no later view makes up for
constexpr std::size_t kMostNew = 8;          // places that a search brings up
constexpr double kHopeless = 1e-5;           // probability in a search
constexpr double kMostOfOneObservation = 5;  // that one observation adds or takes away [nats]
constexpr double kLeast = 1e-3;              // [m, rad]
constexpr std::size_t kMostChains = 4;
// Latest observations that judge a new place: older ones are too uncertain.
constexpr std::size_t kKeptObservations = 6;
constexpr PoseRadius kSharpMotion{0.15, 3};
constexpr double kMostDoubt = 4;       // that a motion can raise: one of fifty is wrong [nats]
constexpr double kAlike = 1;           // difference of observations that count as equal [nats]
constexpr double kUnlikely = 1e-3;     // share of a place, of an alternative that is dropped
constexpr double kChanged = 0.4;       // share of a view that may differ from the map at the right place
constexpr double kMostAgainst = 1;     // that one observation takes away from a place beyond doubt [nats]
constexpr double kEstablished = 0.99;  // probability of a place that is beyond doubt
constexpr double kWorthAsking = 0.01;  // probability of a place that a view is registered near

// Is a place that a search has found one where the camera is thought to be?
bool isThere(const BelievedPlace& place, const Hypothesis& found) {
  if (place.part != found.part) return false;
  if (kSameAnswer.joins(place.T_w_c.T, *found.T_w_c)) return true;
  return squaredMahalanobis(place.T_w_c, *found.T_w_c) < kGate;
}

void sortByOdds(std::vector<BelievedPlace>& places) {
  std::stable_sort(places.begin(), places.end(),
                   [](const BelievedPlace& a, const BelievedPlace& b) { return a.log_odds > b.log_odds; });
}

// Motions one after the other, the likeliest of all combinations.
std::vector<MotionMode> chained(const std::vector<MotionMode>& first, const std::vector<MotionMode>& then) {
  std::vector<MotionMode> all;
  for (const MotionMode& a : first)
    for (const MotionMode& b : then) all.push_back({a.T_a_b * b.T_a_b, a.probability * b.probability});
  std::stable_sort(all.begin(), all.end(),
                   [](const MotionMode& a, const MotionMode& b) { return a.probability > b.probability; });
  if (all.size() > kMostChains) all.resize(kMostChains);
  return all;
}

// How much of an observation counts where only a motion of that uncertainty leads back to it.
double sharpness(const PoseWithCovariance& motion) {
  const double blur = std::max(largestTranslationStd(motion.P) / kSharpMotion.distance,
                               largestRotationStd(motion.P) / (kSharpMotion.angle_deg * kDegree));
  return std::exp(-0.5 * blur * blur);
}

// One Gaussian for two that are close to each other, by their moments.
PoseWithCovariance merged(const PoseWithCovariance& a, double share_of_a, const PoseWithCovariance& b) {
  const Vector6d apart = boxminus(b.T, a.T);
  const double share = 1 - share_of_a;
  return {boxplus(a.T, share * apart),
          share_of_a * a.P + share * b.P + share_of_a * share * apart * apart.transpose()};
}

// The pose, or, if its heading is open, poses of all headings at that position. A Gaussian of such a heading
// cannot be linearized, and an angle has no wider distribution than the uniform one.
std::vector<PoseWithCovariance> headingsOf(const PoseWithCovariance& T_w_c) {
  constexpr double kOpen = 60 * kDegree;  // standard deviation
  constexpr int kHeadings = 12;
  if (T_w_c.P(2, 2) < kOpen * kOpen) return {T_w_c};
  constexpr double kBetween = 2 * EIGEN_PI / kHeadings;
  PoseWithCovariance one = T_w_c;
  one.P.row(2) *= kBetween / 2 / std::sqrt(T_w_c.P(2, 2));
  one.P.col(2) *= kBetween / 2 / std::sqrt(T_w_c.P(2, 2));
  std::vector<PoseWithCovariance> all(kHeadings, one);
  for (int k = 0; k < kHeadings; ++k)
    all[k].T.linear() =
        Eigen::AngleAxisd(k * kBetween, Eigen::Vector3d::UnitZ()).toRotationMatrix() * T_w_c.T.linear();
  return all;
}

double bounded(double log_odds) {
  return std::clamp(log_odds, -kMostOfOneObservation, kMostOfOneObservation);
}

// Change of the log odds of a place relative to the place that the view favours. Equivalent places differ by
// a little in the same way from view to view, since the map shows one of them better: that is no evidence,
// however often.
double added(double log_odds, double best) {
  return bounded(best) - std::min(2 * kMostOfOneObservation, std::max(0.0, best - log_odds - kAlike));
}

Eigen::Isometry3d modelPose(const Hypothesis& h) { return *h.T_w_c * h.T_m_c.T.inverse(); }

std::vector<BelievedPlace> placesOf(const Localization& answer) {
  constexpr double kNowhereLeft = 1e-9;  // rounding error of the probability of nowhere
  const double nowhere = std::max(answer.not_in_map.value_or(1), kNowhereLeft);
  std::vector<BelievedPlace> places;
  for (const Hypothesis& h : answer.hypotheses)
    places.push_back(
        {modelPose(h) * h.T_m_c, h.part, std::log(std::max(h.probability, kNowhereLeft) / nowhere), h});
  return places;
}

bool isSamePlace(const BelievedPlace& a, const BelievedPlace& b) {
  if (a.part != b.part) return false;
  if (kSameAnswer.joins(a.T_w_c.T, b.T_w_c.T)) return true;
  return squaredMahalanobis(a.T_w_c, b.T_w_c) < kGate;
}

// Log odds of a place that is not in a list: no likelier than the last of it, nor than an unlisted
// place.
double oddsOfUnlisted(const std::vector<BelievedPlace>& list) {
  double least = 0;
  for (const BelievedPlace& place : list) least = std::min(least, place.log_odds);
  return least;
}

}  // namespace

PlaceBelief::PlaceBelief(std::shared_ptr<const Map> map, const GlobalLocalizationParams& localization,
                         const LocalizerParams& params)
    : map_(std::move(map)),
      params_(checked(params)),
      calibration_(localization.calibration.sequence),
      prior_(-localization.probability.priorLogOdds()),
      ranking_(map_,
               [&] {
                 GlobalLocalizationParams without_prior = localization;
                 without_prior.probability.map_incomplete = 0.5;  // counts once only
                 return without_prior;
               }()),
      near_(map_, true),
      limits_(localization.sure) {}

void PlaceBelief::clear() {
  places_.clear();
  kept_.clear();
  distance_ = turn_ = 0;
  observations_ = 0;
}

void PlaceBelief::move(const Motion& motion) {
  std::vector<BelievedPlace> moved;
  for (const BelievedPlace& before : places_)
    for (const MotionMode& mode : motion.modes) {
      BelievedPlace place = before;
      place.T_w_c = before.T_w_c * mode.T_a_b;
      place.log_odds += std::log(mode.probability);
      place.match.pairs.clear();  // they were of another view
      moved.push_back(std::move(place));
    }
  places_ = std::move(moved);
  if (motion.none > 0) scatter(motion.none);
  if (motion.modes.size() > 1) normalize();
  std::vector<MotionMode> back;
  for (const MotionMode& mode : motion.modes) back.push_back({inverse(mode.T_a_b), mode.probability});
  for (Observation& observation : kept_) observation.T_c_l = chained(back, observation.T_c_l);
  distance_ += motion.likeliest().T.translation().norm();
  turn_ += rotationAngle(motion.likeliest().T.linear());
}

// The camera may be anywhere now with that probability: the places lose it to nowhere, and observations from
// before do not judge new places.
void PlaceBelief::scatter(double probability) {
  constexpr double kElsewhere = 0.5;
  weigh();
  double left = 1;
  for (BelievedPlace& place : places_) left -= place.probability *= 1 - probability;
  for (BelievedPlace& place : places_)
    place.log_odds = std::log(place.probability) - std::log(std::max(left, kForgotten));
  if (probability > kElsewhere) kept_.clear();
  normalize();
}

double PlaceBelief::motionSince(double distance, double rotation_deg) const {
  return distance_ / distance + turn_ / (rotation_deg * kDegree);
}

std::vector<int> PlaceBelief::modelsAround(int n) const {
  std::vector<int> models;
  for (const BelievedPlace& place : places_) {
    if (place.probability < kWorthAsking) continue;
    const std::vector<int> near = near_.bySight(place.part, place.T_w_c.T, kTrackingReach, n);
    models.insert(models.end(), near.begin(), near.end());
  }
  return models;
}

bool PlaceBelief::isDue() const {
  return observations_ == 0 || motionSince(params_.look_distance, params_.look_rotation_deg) >= 1;
}

void PlaceBelief::inject(int part, const PoseWithCovariance& T_w_c, double log_odds) {
  const std::vector<int> nearest = near_.byPlace(part, T_w_c.T.translation(), 1);
  if (nearest.empty()) return;
  const std::vector<PoseWithCovariance> headings = headingsOf(T_w_c);
  Hypothesis match;
  match.model = nearest.front();
  // Whoever says so knows how wide it is.
  for (const PoseWithCovariance& pose : headings)
    places_.push_back({pose, part, prior_ + log_odds - std::log(headings.size()), match, spreadOf(pose.P)});
  weigh();
}

void PlaceBelief::correct(const PoseWithCovariance& T_w_c, const std::optional<Hypothesis>& match) {
  BelievedPlace& place = places_.front();
  place.T_w_c = T_w_c;
  if (!match) return;
  place.match.model = match->model;
  place.match.pairs = match->pairs;
}

PoseWithCovariance PlaceBelief::poseOf(const Hypothesis& h) const {
  return *map_->models[h.model].T_w_m * h.T_m_c;
}

// Log odds of a place that was known before this view.
double PlaceBelief::oddsOfKnown(const View& view, const Hypothesis& h) const {
  return ranking_.oddsOfKnown(ranking_.mayHaveEvidence(view), h)(h.score);
}

// Log odds of a place that was beyond doubt. Surfaces that the map lacks, those hidden from its local models
// and as much as may have changed since then do not count against it; a thing that has changed stays in view
// for a while, and each observation speaks little of it.
double PlaceBelief::oddsOfEstablished(const View& view, const Hypothesis& h) const {
  const double odds = oddsOfKnown(view, h);
  if (odds >= 0 || !ranking_.mayHaveEvidence(view)) return odds;
  const Coverage& known = h.coverage;
  const double differing = known.contradicted + known.looked_through;
  const double beyond_change = std::max(0.0, differing - kChanged / (1 - kChanged) * known.agreeing);
  return std::max(-kMostAgainst, known.compared * beyond_change * odds);
}

// A Gaussian that is wider than the spacing of local models is as many places: their log.
double PlaceBelief::spreadOf(const Matrix6d& P) {
  constexpr double kSpacing = 0.5, kSpacingDeg = 15;  // spacing of the paper's maps [m, deg]
  const PrincipalStd known = principalStd(P);
  double spread = 0;
  for (int k = 0; k < 3; ++k) {
    spread += std::log(std::max(1.0, known.translation[k] / kSpacing));
    spread += std::log(std::max(1.0, known.rotation[k] / (kSpacingDeg * kDegree)));
  }
  return spread;
}

// Log odds from the kept views of a place that they were not compared with, as far as the motions since are
// known.
double PlaceBelief::historyOf(const Hypothesis& place) const {
  double sum = 0;
  for (const Observation& observation : kept_) {
    double likelihood = 0, known = 0;
    for (const MotionMode& chain : observation.T_c_l) {
      const double sharp = sharpness(chain.T_a_b);
      if (sharp < kUnlikely) continue;
      const auto seen = ranking_.at(Query(*observation.view), place.part, poseOf(place) * chain.T_a_b,
                                    LooseBodies(*observation.view));
      const double odds =
          seen ? observation.weight * sharp * added(oddsOfKnown(*observation.view, *seen), observation.best)
               : 0;
      likelihood += chain.probability * std::exp(odds);
      known += chain.probability;
    }
    if (known > 0) sum += std::log(likelihood + std::max(0.0, 1 - known));
  }
  return sum;
}

// Adds the observations of those that may be a known place to it; returns the others that are likely
// enough.
std::vector<Hypothesis> PlaceBelief::sortFound(const Localization& found,
                                               std::vector<Candidates>& seen) const {
  std::vector<Hypothesis> fresh;
  for (const Hypothesis& h : found.hypotheses) {
    if (!h.T_w_c || !map_->models[h.model].T_w_m) continue;
    const auto known = std::find_if(places_.begin(), places_.end(),
                                    [&h](const BelievedPlace& place) { return isThere(place, h); });
    if (known == places_.end()) {
      if (h.probability > kHopeless && fresh.size() < kMostNew) fresh.push_back(h);
      continue;
    }
    Candidates& there = seen[known - places_.begin()];
    const auto same = std::find_if(there.begin(), there.end(), [&h](const Candidate& other) {
      return kSameMotion.joins(*other.match.T_w_c, *h.T_w_c);
    });
    if (same != there.end() && h.score <= same->match.score) continue;
    Candidate candidate{h, covarianceIntersection(known->T_w_c, poseOf(h))};
    if (same == there.end())
      there.push_back(std::move(candidate));
    else
      *same = std::move(candidate);
  }
  return fresh;
}

std::optional<double> PlaceBelief::observe(std::shared_ptr<const View> view, const Localization& found,
                                           bool independent) {
  const double independence = observations_ == 0 || independent
                                  ? 1
                                  : 1 - std::exp(-motionSince(calibration_.independent_distance,
                                                              calibration_.independent_rotation_deg));
  for (BelievedPlace& place : places_) {  // a place found within a wide one is one of many
    const double now = spreadOf(place.T_w_c.P);
    place.log_odds -= std::max(0.0, now - place.spread);
    place.spread = now;
  }
  const Query query(*view);
  std::vector<Candidates> seen(places_.size());
  LooseBodies bodies(*view);
  const auto look = [&](int i) {
    const auto there = ranking_.at(query, places_[i].part, places_[i].T_w_c, bodies);
    if (!there) return;
    PoseWithCovariance T_w_c = poseOf(*there);
    T_w_c.P = temper(places_[i].T_w_c.P, T_w_c.P, independence);
    seen[i].push_back({*there, T_w_c});
  };
  if (!places_.empty()) {  // the likeliest place tells which bodies are furniture
    look(0);
    if (!seen[0].empty()) bodies.keep(ranking_.furnitureAt(seen[0].front().match, bodies));
    forEachInParallel(static_cast<int>(places_.size()) - 1, threads_, [&](int i) { look(i + 1); });
  }
  const std::vector<Hypothesis> fresh = sortFound(found, seen);
  double best = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < seen.size(); ++i)
    for (Candidate& candidate : seen[i]) {
      const bool is_established =
          !independent && places_[i].probability >= kEstablished && limits_.hold(places_[i].T_w_c.P);
      candidate.log_odds =
          is_established ? oddsOfEstablished(*view, candidate.match) : oddsOfKnown(*view, candidate.match);
      best = std::max(best, candidate.log_odds);
    }
  std::optional<double> of_best;
  std::vector<BelievedPlace> places;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    std::vector<BelievedPlace> now = updated(places_[i], seen[i], best, independence);
    if (i == 0 && !seen[i].empty()) of_best = now.front().log_odds - places_[i].log_odds;
    std::move(now.begin(), now.end(), std::back_inserter(places));
  }
  places_ = std::move(places);
  best = std::max(best, addFresh(*view, fresh, seen, independence));
  ++observations_;
  distance_ = turn_ = 0;
  PoseWithCovariance here;
  here.P = kLeast * kLeast * Matrix6d::Identity();
  kept_.push_back({std::move(view), {{here, 1}}, independence, best});
  while (kept_.size() > kKeptObservations) kept_.pop_front();
  normalize();
  return of_best;
}

// The first place and the one heard contradict each other as far as they are apart, and one motion of fifty
// is wrong.
void PlaceBelief::hear(const Hypothesis& sure) {
  constexpr double kMostProbable = 0.998;  // two of a thousand single answers may be wrong
  constexpr double kBelieved = 0.5;        // probability of a first place that there is to contradict
  if (places_.empty() || places_.front().probability < kBelieved) return;
  const auto isHeard = [&sure](const BelievedPlace& place) {
    return place.part == sure.part && kSamePlace.joins(place.T_w_c.T, *sure.T_w_c);
  };
  const BelievedPlace& first = places_.front();
  if (isHeard(first)) return;
  const double doubt = first.part == sure.part
                           ? std::min(kMostDoubt, 0.5 * squaredMahalanobis(first.T_w_c, *sure.T_w_c))
                           : kMostDoubt;
  auto own = std::find_if(places_.begin(), places_.end(), isHeard);
  if (own == places_.end())
    own = places_.insert(own, {poseOf(sure), sure.part, -std::numeric_limits<double>::infinity(), sure});
  double others = 1;
  for (auto place = places_.begin(); place != places_.end(); ++place)
    if (place != own) others += std::exp(place->log_odds);
  const double p = std::min(kMostProbable, sure.probability);
  own->log_odds = std::max(own->log_odds, std::log(others * p / (1 - p)) - doubt);
  normalize();
}

// A place, after a view has been seen at one or several poses within its uncertainty: the best of them, and
// the others beside it. The first one is the likeliest.
std::vector<BelievedPlace> PlaceBelief::updated(const BelievedPlace& place, const Candidates& seen,
                                                double best, double weight) {
  if (seen.empty()) return {place};
  std::vector<double> off;
  for (const Candidate& candidate : seen)
    off.push_back(std::min(kMostDoubt, 0.5 * squaredMahalanobis(place.T_w_c, *candidate.match.T_w_c)));
  const double nearest = *std::min_element(off.begin(), off.end());
  std::vector<BelievedPlace> now;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    BelievedPlace there = place;
    there.log_odds += weight * added(seen[i].log_odds, best) - (off[i] - nearest);
    there.T_w_c = seen[i].T_w_c;
    there.match = seen[i].match;
    now.push_back(std::move(there));
  }
  sortByOdds(now);
  const double least = now.front().log_odds + std::log(kUnlikely);
  while (now.back().log_odds < least) now.pop_back();
  return now;
}

// Places that a search has brought up are the best of many: for this view, they are ranked as it ranks them.
// Returns the log odds of the place that the view likes best.
double PlaceBelief::addFresh(const View& view, const std::vector<Hypothesis>& fresh,
                             const std::vector<Candidates>& seen, double weight) {
  std::vector<Hypothesis> list = fresh;
  for (const Candidates& there : seen)
    for (const Candidate& candidate : there) list.push_back(candidate.match);
  sortByScore(list);
  const ScoreOdds odds = ranking_.odds(ranking_.mayHaveEvidence(view), list);
  double best = -kMostOfOneObservation;
  for (const Hypothesis& h : fresh) best = std::max(best, odds(h.score));
  for (const Candidates& there : seen)
    for (const Candidate& candidate : there) best = std::max(best, candidate.log_odds);
  std::vector<double> before(fresh.size());
  forEachInParallel(static_cast<int>(fresh.size()), threads_,
                    [&](int i) { before[i] = historyOf(fresh[i]); });
  for (std::size_t i = 0; i < fresh.size(); ++i)
    places_.push_back({poseOf(fresh[i]), fresh[i].part,
                       prior_ + before[i] + weight * added(odds(fresh[i].score), best), fresh[i]});
  return best;
}

// One place once; those that are forgotten go; probabilities.
void PlaceBelief::normalize() {
  sortByOdds(places_);
  std::vector<BelievedPlace> kept;
  const double beyond = places_.empty() ? 0 : std::max(0.0, places_.front().log_odds - kMostLogOdds);
  for (BelievedPlace& place : places_) {
    place.log_odds -= beyond;
    if (place.log_odds < std::log(kForgotten)) continue;
    const auto same = std::find_if(kept.begin(), kept.end(), [&](const BelievedPlace& other) {
      return other.part == place.part && kSameAnswer.joins(other.T_w_c.T, place.T_w_c.T);
    });
    if (same != kept.end()) {
      const double ratio = std::exp(place.log_odds - same->log_odds);
      if (ratio > kUnlikely) same->T_w_c = merged(same->T_w_c, 1 / (1 + ratio), place.T_w_c);
      continue;
    }
    if (static_cast<int>(kept.size()) < params_.max_places) kept.push_back(std::move(place));
  }
  places_ = std::move(kept);
  weigh();
}

void PlaceBelief::weigh() {
  double sum = 1;
  for (const BelievedPlace& place : places_) sum += std::exp(place.log_odds);
  for (BelievedPlace& place : places_) place.probability = std::exp(place.log_odds) / sum;
}

Localization smoothedPlaces(const Localization& until_now, const Localization& from_next,
                            const PoseWithCovariance& T_now_next, double prior) {
  std::vector<BelievedPlace> places = placesOf(until_now), later = placesOf(from_next);
  const double unlisted = oddsOfUnlisted(places), unlisted_later = oddsOfUnlisted(later);
  const PoseWithCovariance T_next_now = inverse(T_now_next);
  for (BelievedPlace& place : later) {
    place.T_w_c = place.T_w_c * T_next_now;
    place.match.pairs.clear();  // they are of another view
  }
  for (BelievedPlace& place : places) {
    const auto same = std::find_if(later.begin(), later.end(),
                                   [&](const BelievedPlace& other) { return isSamePlace(place, other); });
    place.log_odds += (same != later.end() ? same->log_odds : unlisted_later) - prior;
    if (same == later.end()) continue;
    place.T_w_c = covarianceIntersection(place.T_w_c, same->T_w_c);
    later.erase(same);
  }
  for (BelievedPlace& place : later) {
    place.log_odds += unlisted - prior;
    places.push_back(std::move(place));
  }
  sortByOdds(places);
  double sum = 1;
  for (const BelievedPlace& place : places) sum += std::exp(place.log_odds);

  Localization out;
  out.not_in_map = 1 / sum;
  out.looks = until_now.looks + from_next.looks - 1;  // views next to each other tell the same
  out.T_before_now = until_now.T_before_now;
  for (BelievedPlace& place : places) {
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
