// SPDX-License-Identifier: BSD-3-Clause
#include "ranking/place_ranking.h"

#include "nearby/view_alignment.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

namespace facetloc::internal {
namespace {

constexpr ViewReach kReach{2.5, 50 * kDegree};  // of models that may show what the scene shows

// What several models say about one world pose: all together about each pixel of the scene, and one by one
// about their own pixels, moved into the scene.
struct DepthEvidence {
  DepthAgreement of_scene;
  int pixels = 0;  // of the scene
  std::vector<DepthAgreement> of_models;
};

double weighed(const DepthEvidence& found, double free_space_share, const EvidenceCalibration& params) {
  const auto tail = [&](double share) { return std::log1p(share / free_space_share); };
  const double untested = params.untested_pixels * found.pixels;
  const auto contradiction = [&](const DepthAgreement& a, double untested_here) {
    const double n = a.judged() + untested_here;
    return tail(n > 0 ? (a.contradict + untested_here * params.untested_contradiction) / n : 0);
  };
  // The models' pixels are counted on the coarser grid.
  constexpr double kCoarser = double(kCoarseColumns * kCoarseColumns) / (kFineColumns * kFineColumns);
  double of_models = 0, hidden = 0;
  int tested = 0;
  for (const DepthAgreement& a : found.of_models) {
    if (a.judged() == 0) continue;
    ++tested;
    of_models += contradiction(a, kCoarser * untested);
    hidden += tail(a.occluded / static_cast<double>(a.judged()));
  }
  if (tested > 0)
    of_models /= tested, hidden /= tested;
  else
    of_models = contradiction({}, untested);
  const double disagreement =
      (found.of_scene.judged() - found.of_scene.agree) / std::max(1.0, double(found.pixels));
  return -params.contradiction_weight * (contradiction(found.of_scene, untested) + of_models) -
         params.occlusion_weight * hidden - params.disagreement_weight * disagreement;
}

Explanation explanationOf(const DepthEvidence& found, const View& scene,
                          const std::vector<SegmentPair>& pairs) {
  const auto share = [](double part, double of) { return of > 0 ? part / of : 0; };
  const DepthAgreement& a = found.of_scene;
  std::vector<char> has_partner(scene.segments.size(), 0);
  for (const SegmentPair& pair : pairs) has_partner[pair.scene] = 1;
  double all = 0, paired = 0;
  for (std::size_t i = 0; i < scene.segments.size(); ++i) {
    all += scene.segments[i].num_points;
    if (has_partner[i]) paired += scene.segments[i].num_points;
  }
  return {share(a.judged(), found.pixels), share(a.agree, a.judged()), share(a.contradict, a.judged()),
          share(paired, all)};
}

void sortByScore(std::vector<Hypothesis>& h) {
  std::stable_sort(h.begin(), h.end(),
                   [](const Hypothesis& a, const Hypothesis& b) { return a.score > b.score; });
}

bool samePlace(const Hypothesis& a, const Hypothesis& b) {
  return a.part == b.part && a.T_w_c && b.T_w_c && kSamePlace.joins(*a.T_w_c, *b.T_w_c);
}

// Are these answers that exclude each other? Poses that are close to each other are one, found more or less
// well.
bool areRivals(const Hypothesis& a, const Hypothesis& b) {
  if (a.part != b.part) return true;
  if (a.T_w_c && b.T_w_c) return !kSameAnswer.joins(*a.T_w_c, *b.T_w_c);
  return a.model != b.model || !kSameAnswer.joins(a.T_m_c.T, b.T_m_c.T);
}

// What wrong places score for the map's own views; of few views, drawn towards the usual.
double meanAmbiguity(const ProbabilityCalibration& params, const std::optional<MapAmbiguity>& ambiguity) {
  constexpr double kViews = 20;  // that the usual ambiguity counts as
  const MapAmbiguity found = ambiguity.value_or(MapAmbiguity());
  return (found.views * found.score + kViews * params.usual_ambiguity) / (found.views + kViews);
}

}  // namespace

DepthCalibration refinedErrors(const Calibration& calibration) {
  DepthCalibration depth = calibration.depth;
  depth.absolute_error = calibration.refined_depth.absolute_error;
  depth.relative_error = calibration.refined_depth.relative_error;
  return depth;
}

PlaceRanking::PlaceRanking(std::shared_ptr<const Map> map, const GlobalLocalizationParams& params)
    : map_(std::move(map)),
      params_(params),
      comparison_(params.calibration.depth),
      refined_comparison_(refinedErrors(params.calibration)),
      score_(hypothesisScore(params, comparison_)),
      alignment_(alignmentWithCovariance()),
      near_(map_, true) {
  alignment_.matching = params.matching;
}

void PlaceRanking::rank(const View& scene, std::vector<Hypothesis>& hypotheses) const {
  // The paper's score counts pixels: nats of evidence do not add to it.
  const bool evidence = !params_.score.by_overlap && addEvidence(scene, hypotheses);
  mergePlaces(params_.merging, hypotheses);
  if (evidence) score(hypotheses);
  if (evidence && params_.refinement.enabled) refinePlaces(scene, hypotheses);
  if (evidence && map_->models.size() == 1) {
    for (Hypothesis& h : hypotheses) h.score = together(h);
    sortByScore(hypotheses);
  }
  const ScoreOdds found = odds(evidence, hypotheses);
  assignProbabilities(found.slope, found.null_score, hypotheses);
}

// Of two views, the one picture says little beside the segments.
double PlaceRanking::together(const Hypothesis& h) const {
  const double weight = map_->models.size() == 1 ? params_.calibration.pair_probability.evidence_weight : 1;
  return h.consensus + weight * h.evidence;
}

bool PlaceRanking::mayHaveEvidence(const View& scene) const {
  return params_.evidence.enabled && !params_.score.by_overlap && !scene.depth.empty() && !near_.empty();
}

// What looks like a place scores no more than what looks like the places of the map that have most of it.
double PlaceRanking::lookalikesOf(const Hypothesis& place, double share_of_place) const {
  const double of_map = meanAmbiguity(params_.calibration.probability, map_->ambiguity);
  std::optional<double> of_place;
  for (const int i : near_.bySight(place.part, *place.T_w_c, kReach, params_.evidence.models))
    if (const auto& score = map_->models[i].lookalike_score)
      of_place =
          std::max({*score, of_place.value_or(*score), params_.calibration.probability.least_null_score});
  return of_place ? std::min(of_map, of_map + share_of_place * (*of_place - of_map)) : of_map;
}

ScoreOdds PlaceRanking::oddsOfKnown(bool evidence, double lookalike_weight, double share_of_place,
                                    const Hypothesis& place) const {
  if (!evidence || map_->models.size() == 1) return odds(evidence, {});
  const ProbabilityCalibration& p = params_.calibration.probability;
  const double prior = params_.probability.priorLogOdds();
  return {p.slope, (1 - lookalike_weight) * p.least_null_score +
                       lookalike_weight * lookalikesOf(place, share_of_place) + prior / p.slope};
}

ScoreOdds PlaceRanking::odds(bool evidence, const std::vector<Hypothesis>& sorted) const {
  if (map_->models.size() == 1) {
    const PairProbabilityCalibration& p = params_.calibration.pair_probability;
    const double slope = evidence ? p.slope : p.segments_slope;
    const double null_score = evidence ? p.null_score : p.segments_null_score;
    return {slope, null_score + params_.probability.priorLogOdds() / slope};
  }
  const ProbabilityCalibration& p = params_.calibration.probability;
  if (evidence) return {p.slope, nullScore(p, params_.probability, map_->ambiguity, sorted)};
  return {params_.calibration.plain_probability.slope, params_.calibration.plain_probability.null_score};
}

std::optional<Hypothesis> PlaceRanking::at(const Query& query, int part,
                                           const PoseWithCovariance& T_w_c) const {
  Hypothesis h;
  h.part = part;
  h.T_w_c = T_w_c.T;
  const std::vector<int> models = near_.bySight(part, T_w_c.T, kReach, params_.evidence.models);
  if (models.empty()) return {};
  Surroundings surroundings;
  std::vector<Neighbour> around;
  for (const int i : models) {
    around.push_back({map_->view(i), *map_->models[i].T_w_m});
    surroundings.add(i, around.back().view, around.back().T_w_m);
  }
  const ViewAlignment aligned = alignView(query.view, surroundings, T_w_c, alignment_);
  h.T_w_c = aligned.T_w_c.T;
  std::optional<Hypothesis> best;
  for (std::size_t i = 0; i < models.size(); ++i) {
    h.model = models[i];
    h.T_m_c = around[i].T_w_m.inverse() * aligned.T_w_c;
    score_->score(query, *around[i].view, kFineColumns, h);
    if (!best || h.consensus > best->consensus) best = h;
  }
  for (const SegmentPair& pair : aligned.pairs) {
    const Surroundings::Origin& origin = surroundings.origins[pair.model];
    if (origin.view == best->model) best->pairs.push_back({pair.scene, origin.segment, pair.distance});
  }
  best->found_by = {best->model};
  if (mayHaveEvidence(query.view)) best->evidence = evidence(query.view, around, *best, refined_comparison_);
  best->score = together(*best);
  return best;
}

std::vector<PlaceRanking::Neighbour> PlaceRanking::neighbours(const Hypothesis& h) const {
  std::vector<Neighbour> found;
  for (const int i : near_.bySight(h.part, *h.T_w_c, kReach, params_.evidence.models))
    found.push_back({map_->view(i), *map_->models[i].T_w_m});
  return found;
}

// Also tells the hypothesis what it explains.
double PlaceRanking::evidence(const View& scene, const std::vector<Neighbour>& neighbours, Hypothesis& h,
                              const DepthComparison& comparison) const {
  const Eigen::Isometry3d& T_w_c = *h.T_w_c;
  DepthEvidence found;
  std::vector<PosedPicture> pictures;
  for (const Neighbour& n : neighbours) {
    const DepthPicture& depth = n.view->depth;
    const Eigen::Isometry3d T_m_c = n.T_w_m.inverse() * T_w_c;
    pictures.push_back({&depth, n.T_w_m});
    found.of_models.push_back(comparison.compare(depth, scene.depth, T_m_c.inverse(), kCoarseColumns));
  }
  found.of_scene = compareWithAll(scene.depth, T_w_c, pictures, comparison, kFineColumns);
  const int step = gridStep(scene.depth, kFineColumns);
  found.pixels = gridPoints(scene.depth.camera.width, step) * gridPoints(scene.depth.camera.height, step);
  h.explained = explanationOf(found, scene, h.pairs);
  return weighed(found, params_.calibration.score.free_space_share, params_.calibration.evidence);
}

// Moves a hypothesis, within its place, to where the pixels of these models fit best.
void PlaceRanking::refine(const View& scene, const std::vector<Neighbour>& neighbours, Hypothesis& h) const {
  std::vector<PosedPicture> pictures;
  for (const Neighbour& n : neighbours) pictures.push_back({&n.view->depth, n.T_w_m});
  const Eigen::Isometry3d& T_w_m = *map_->models[h.model].T_w_m;
  PoseWithCovariance pose = T_w_m * h.T_m_c;
  Matrix6d of_pixels;
  if (!refineByDepth(scene.depth, pictures, {}, pose, &of_pixels)) return;
  if (!kSamePlace.joins(*h.T_w_c, pose.T)) return;  // that is no refinement: planes found another place
  // What a sensor always measures wrongly all its pixels share: while it is left in, they tell no more than
  // the planes, whose covariance counts with it.
  if (scene.camera && scene.camera->distortion) {
    const Matrix6d of_planes = pose.P.ldlt().solve(Matrix6d::Identity());
    pose.P = symmetricInverse(of_planes + of_pixels / params_.calibration.refined_depth.pixels_as_one);
  }
  h.T_w_c = pose.T;
  h.T_m_c = T_w_m.inverse() * pose;
}

// How many of the sorted hypotheses, at most so many, are not hopeless beside the best.
std::size_t PlaceRanking::hopeful(const std::vector<Hypothesis>& sorted, int most, double slope) const {
  if (sorted.empty()) return 0;
  const double least = sorted.front().score + std::log(params_.calibration.evidence.hopeless_odds) / slope;
  const auto end =
      sorted.begin() + std::min<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(sorted.size()), most);
  const auto isHopeless = [least](const Hypothesis& h) { return h.score < least; };
  return static_cast<std::size_t>(std::find_if(sorted.begin(), end, isHopeless) - sorted.begin());
}

bool PlaceRanking::addEvidence(const View& scene, std::vector<Hypothesis>& hypotheses) const {
  sortByScore(hypotheses);
  if (!params_.evidence.enabled || scene.depth.empty()) return false;
  const std::size_t n =
      hopeful(hypotheses, params_.evidence.hypotheses, params_.calibration.plain_probability.slope);
  bool any = false;
  double least = std::numeric_limits<double>::infinity();
  std::vector<double> found(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    Hypothesis& h = hypotheses[i];
    if (!h.T_w_c) continue;
    const std::vector<Neighbour> models = neighbours(h);
    found[i] = evidence(scene, models, h, comparison_);
    any = any || !models.empty();
    least = std::min(least, found[i]);
  }
  if (!any) return false;
  for (std::size_t i = 0; i < hypotheses.size(); ++i) {
    Hypothesis& h = hypotheses[i];
    h.evidence = i < n && h.T_w_c ? found[i] : least;
    h.score = h.consensus + h.evidence;
  }
  return true;
}

void PlaceRanking::refinePlaces(const View& scene, std::vector<Hypothesis>& hypotheses) const {
  const std::size_t n = hopeful(hypotheses, params_.refinement.places, params_.calibration.probability.slope);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < n; ++i) {
    Hypothesis& h = hypotheses[i];
    if (!h.T_w_c) continue;
    const std::vector<Neighbour> models = neighbours(h);
    refine(scene, models, h);
    h.evidence = evidence(scene, models, h, refined_comparison_);
    least = std::min(least, h.evidence);
  }
  // The others are compared with the larger errors of a pose that is not refined, which is no merit.
  for (std::size_t i = 0; i < hypotheses.size(); ++i) {
    Hypothesis& h = hypotheses[i];
    if (i >= n || !h.T_w_c) h.evidence = std::min(h.evidence, least);
  }
  score(hypotheses);
  mergePlaces(params_.merging, hypotheses);
  score(hypotheses);
}

// Models of one pose show the same, as where a map has been merged with itself.
int PlaceRanking::viewpoints(const std::vector<int>& models) const {
  std::vector<Eigen::Isometry3d> poses;
  int n = 0;
  for (const int i : models) {
    const std::optional<Eigen::Isometry3d>& T_w_m = map_->models[i].T_w_m;
    const auto isThere = [&](const Eigen::Isometry3d& T) { return kSamePlace.joins(T, *T_w_m); };
    if (T_w_m && std::any_of(poses.begin(), poses.end(), isThere)) continue;
    if (T_w_m) poses.push_back(*T_w_m);
    ++n;
  }
  return n;
}

// Local models see a place from different sides: several that find it by themselves hardly err alike.
void PlaceRanking::score(std::vector<Hypothesis>& places) const {
  for (Hypothesis& h : places)
    h.score = h.consensus + h.evidence +
              params_.calibration.evidence.support_weight * std::log(std::max(1, viewpoints(h.found_by)));
  sortByScore(places);
}

void mergePlaces(const MergingParams& params, std::vector<Hypothesis>& hypotheses) {
  sortByScore(hypotheses);
  if (!params.enabled) return;
  std::vector<Hypothesis> places;
  for (Hypothesis& h : hypotheses) {
    if (h.found_by.empty()) h.found_by = {h.model};
    const auto known =
        std::find_if(places.begin(), places.end(), [&](const Hypothesis& p) { return samePlace(p, h); });
    if (known == places.end()) {
      places.push_back(std::move(h));
      continue;
    }
    std::vector<int> models;
    std::set_union(known->found_by.begin(), known->found_by.end(), h.found_by.begin(), h.found_by.end(),
                   std::back_inserter(models));
    known->found_by.swap(models);
  }
  hypotheses.swap(places);
}

double nullScore(const ProbabilityCalibration& params, const ProbabilityParams& prior,
                 const std::optional<MapAmbiguity>& ambiguity, const std::vector<Hypothesis>& sorted) {
  const double of_all_views =
      params.ambiguity_weight * meanAmbiguity(params, ambiguity) + prior.priorLogOdds() / params.slope;

  const std::size_t end = std::min<std::size_t>(sorted.size(), 1 + params.runners_up);
  if (end < 2) return params.least_null_score + of_all_views;
  double sum = 0;
  for (std::size_t i = 1; i < end; ++i) sum += sorted[i].score;
  return of_all_views +
         std::max(params.least_null_score,
                  params.null_score + params.runners_up_weight * sum / static_cast<double>(end - 1));
}

void assignProbabilities(double slope, double null_score, std::vector<Hypothesis>& hypotheses) {
  if (hypotheses.empty()) return;
  const double largest = std::max(hypotheses.front().score, null_score);  // keeps the exponentials in range
  double sum = std::exp(slope * (null_score - largest));
  for (Hypothesis& h : hypotheses) sum += h.probability = std::exp(slope * (h.score - largest));
  for (Hypothesis& h : hypotheses) h.probability /= sum;
  for (auto h = hypotheses.begin(); h != hypotheses.end(); ++h) {
    const auto better = std::find_if(hypotheses.begin(), h, [&](const Hypothesis& other) {
      return other.probability > 0 && !areRivals(other, *h);
    });
    if (better != h) better->probability += std::exchange(h->probability, 0);
  }
}

}  // namespace facetloc::internal
