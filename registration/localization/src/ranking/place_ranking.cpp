// SPDX-License-Identifier: BSD-3-Clause
#include "ranking/place_ranking.h"

#include <facetloc/features/map_metadata.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace facetloc::internal {
namespace {

constexpr int kEvidenceModels = 5;  // nearest ones that give evidence of a place: more see the same pixels

// Mean score of wrong places for the map's own views; with few views, drawn towards the usual.
double meanAmbiguity(const ProbabilityCalibration& params, const std::optional<MapAmbiguity>& ambiguity) {
  const MapAmbiguity found = ambiguity.value_or(MapAmbiguity());
  const double views = found.score < params.usual_ambiguity ? params.distinct_views : params.usual_views;
  return (found.views * found.score + views * params.usual_ambiguity) / (found.views + views);
}

// The scores of wrong places lie the closer together the lower they are: beta grows where the map has no
// places that look the same.
double slopeOf(const ProbabilityCalibration& params, const std::optional<MapAmbiguity>& ambiguity) {
  return params.slope * std::exp(std::max(0.0, -meanAmbiguity(params, ambiguity)) / params.distinct_scale);
}

}  // namespace

PlaceRanking::PlaceRanking(std::shared_ptr<const Map> map, const GlobalLocalizationParams& params)
    : HypothesisRanking(params, surfacesOf(*map), consideredErrorsOf(*map)),
      map_(std::move(map)),
      params_(params),
      score_(params, comparison(false)),
      alignment_(alignmentWithCovariance(true, params.matching)),
      near_(map_, true),
      rendered_(renderedViews(*map_)) {}

bool PlaceRanking::mayHaveEvidence(const View& scene) const {
  return params_.evidence.enabled && !params_.score.by_overlap && !scene.depth.empty() && !near_.empty();
}

// Score of wrong matches: the map's, moved by a share towards the highest of the models around the place.
double PlaceRanking::aliasScoreOf(const Hypothesis& place) const {
  const double share_of_place = params_.calibration.sequence.lookalike_share_of_place;
  const double of_map = meanAmbiguity(params_.calibration.probability, map_->mapOf(place.part).ambiguity);
  std::optional<double> of_place;
  for (const int i : near_.bySight(place.part, *place.T_w_c, kEvidenceReach, kEvidenceModels))
    if (const auto& score = map_->models[i].alias_score)
      of_place =
          std::max({*score, of_place.value_or(*score), params_.calibration.probability.least_null_score});
  return of_place ? std::min(of_map, of_map + share_of_place * (*of_place - of_map)) : of_map;
}

ScoreOdds PlaceRanking::oddsOfKnown(bool evidence, const Hypothesis& place) const {
  if (!evidence || map_->models.size() == 1) return odds(evidence, {});
  const ProbabilityCalibration& p = params_.calibration.probability;
  const double prior = params_.probability.priorLogOdds(),
               slope = slopeOf(p, map_->mapOf(place.part).ambiguity),
               weight = params_.calibration.sequence.lookalike_weight;
  return {slope, (1 - weight) * p.least_null_score + weight * aliasScoreOf(place) + prior / slope};
}

ScoreOdds PlaceRanking::odds(bool evidence, const std::vector<Hypothesis>& sorted) const {
  if (map_->models.size() == 1) return oddsOfPair(params_, evidence);
  const ProbabilityCalibration& p = params_.calibration.probability;
  if (evidence) {
    const auto& ambiguity = map_->mapOf(sorted.empty() ? 0 : sorted.front().part).ambiguity;
    return {slopeOf(p, ambiguity), nullScore(p, params_.probability, ambiguity, sorted)};
  }
  return {params_.calibration.plain_probability.slope, params_.calibration.plain_probability.null_score};
}

std::optional<Hypothesis> PlaceRanking::at(const Query& query, int part, const PoseWithCovariance& T_w_c,
                                           const LooseBodies& bodies) const {
  Hypothesis h;
  h.part = part;
  h.T_w_c = T_w_c.T;
  const std::vector<NearbyView> around = neighbours(h);
  if (around.empty()) return {};
  LocalMap surroundings;
  for (const NearbyView& n : around) surroundings.add(n.model, n.view, n.T_w_m);
  const ViewAlignment aligned = alignView(query.view, surroundings, T_w_c, alignment_);
  h.T_w_c = aligned.T_w_c.T;
  std::optional<Hypothesis> best;
  for (const NearbyView& n : around) {
    h.model = n.model;
    h.T_m_c = n.T_w_m.inverse() * aligned.T_w_c;
    score_.score(query, *n.view, kFineColumns, h);
    if (!best || h.consensus > best->consensus) best = h;
  }
  for (const SegmentPair& pair : aligned.pairs) {
    const LocalMap::Origin& origin = surroundings.origins[pair.model];
    if (origin.view == best->model) best->pairs.push_back({pair.scene, origin.segment, pair.distance});
  }
  best->supporting_models = {best->model};
  if (mayHaveEvidence(query.view))
    best->evidence = evidence(query.view, bodies, around, *best, comparison(true));
  best->score = best->consensus + evidenceWeight() * best->evidence;
  return best;
}

double PlaceRanking::oddsOfOther(const View& seen, const View& here, const View& other) const {
  constexpr double kCommon = 0.1;  // least share of the pixels that is compared
  LooseBodies bodies(seen);
  const auto evidenceOf = [&](const View& expected) -> std::optional<double> {
    Hypothesis h;
    h.T_w_c = Eigen::Isometry3d::Identity();
    const double found = evidence(seen, bodies, {{unowned(expected), *h.T_w_c}}, h, comparison(false));
    return h.coverage.compared >= kCommon ? std::optional(found) : std::nullopt;
  };
  const std::optional<double> of_here = evidenceOf(here);
  const Eigen::Isometry3d identity = Eigen::Isometry3d::Identity();
  bodies.keep(bodies.shown(identity, {{&here.depth, identity}}, comparison(false)));
  const std::optional<double> of_other = evidenceOf(other);
  return of_here && of_other ? std::min(0.0, odds(true, {}).slope * (*of_other - *of_here)) : 0;
}

std::vector<NearbyView> PlaceRanking::neighbours(const Hypothesis& h) const {
  std::vector<NearbyView> found;
  for (const int i : near_.bySight(h.part, *h.T_w_c, kEvidenceReach, kEvidenceModels))
    found.push_back({map_->view(i), *map_->models[i].T_w_m, i});
  return found;
}

Eigen::Isometry3d PlaceRanking::poseOfModel(const Hypothesis& h) const {
  return *map_->models[static_cast<std::size_t>(h.model)].T_w_m;
}

// The one picture in a registration of two views is little evidence compared with the segments.
double PlaceRanking::evidenceWeight() const {
  return map_->models.size() == 1 ? params_.calibration.pair_probability.evidence_weight : 1;
}

// Models with equal poses show the same, as where a map has been merged with itself; rendered ones, the
// surfaces of others.
int PlaceRanking::viewpoints(const std::vector<int>& models) const {
  std::vector<Eigen::Isometry3d> poses;
  int n = 0;
  for (const int i : models) {
    if (rendered_[static_cast<std::size_t>(i)]) continue;
    const std::optional<Eigen::Isometry3d>& T_w_m = map_->models[i].T_w_m;
    const auto isThere = [&](const Eigen::Isometry3d& T) { return kSamePlace.joins(T, *T_w_m); };
    if (T_w_m && std::any_of(poses.begin(), poses.end(), isThere)) continue;
    if (T_w_m) poses.push_back(*T_w_m);
    ++n;
  }
  return n;
}

double nullScore(const ProbabilityCalibration& params, const ProbabilityParams& prior,
                 const std::optional<MapAmbiguity>& ambiguity, const std::vector<Hypothesis>& sorted) {
  const double mean = meanAmbiguity(params, ambiguity);
  const double of_all_views = (mean < 0 ? params.distinct_weight : params.ambiguity_weight) * mean +
                              prior.priorLogOdds() / slopeOf(params, ambiguity);

  const std::size_t end = std::min<std::size_t>(sorted.size(), 1 + params.runners_up);
  if (end < 2) return params.least_null_score + of_all_views;
  double sum = 0;
  for (std::size_t i = 1; i < end; ++i) sum += sorted[i].score;
  return of_all_views +
         std::max(params.least_null_score,
                  params.null_score + params.runners_up_weight * sum / static_cast<double>(end - 1));
}

}  // namespace facetloc::internal
