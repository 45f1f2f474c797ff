// SPDX-License-Identifier: BSD-3-Clause
#include "ranking/global_localization.h"

#include "pairs/mounting_check.h"
#include "threads/in_parallel.h"

#include <facetloc/features/map_metadata.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace facetloc::internal {
namespace {

constexpr double kLowest = std::numeric_limits<double>::lowest();  // score
constexpr double kMuchBetter = 10;  // score of a turned camera than of one that is not [nats]: few are turned

/** Does a view show a large plane below its camera, if that is turned so? */
bool showsFloor(const View& view, const Eigen::Isometry3d& T_m_c) {
  constexpr double kSteepest = 50 * kDegree;
  constexpr int kLeastSupport = 300;  // [px]
  return std::any_of(view.segments.begin(), view.segments.end(), [&](const Segment& s) {
    return s.num_points >= kLeastSupport && (T_m_c.linear() * s.normal()).y() > std::cos(kSteepest);
  });
}

/** With constants for maps that lack surfaces, if the map does: half of the surfaces of a scene may not be
 * in them. */
GlobalLocalizationParams paramsFor(const Map& map, GlobalLocalizationParams params) {
  constexpr double kEvenOdds = 0.5;
  if (lacksSurfaces(map))
    params.calibration.score.match_probability =
        std::min(kEvenOdds, params.calibration.score.match_probability);
  return params;
}

double bestScore(const std::vector<Hypothesis>& found) {
  double best = kLowest;
  for (const Hypothesis& h : found) best = std::max(best, h.score);
  return best;
}

}  // namespace

GlobalLocalization::GlobalLocalization(std::shared_ptr<const Map> map, const GlobalLocalizationParams& params)
    : map_(std::move(map)),
      params_(paramsFor(*map_, checked(params))),
      registration_(params_),
      shortlist_(map_, params_),
      ranking_(map_, params_) {
  on_floor_.P = posePrior(map_->camera.mounting, params_.prior);
  anywhere_.P = posePrior({}, params_.prior);
  if (params_.steps.floor_information) of_floor_ = floorInformation(map_->camera.mounting, params_.prior);
}

// Prior for cameras with different mountings, about the difference of both.
PoseWithCovariance GlobalLocalization::priorOf(const View& view, const CameraDifference& camera) const {
  if (camera.sameMounting()) return on_floor_;
  PoseWithCovariance prior = anywhere_;
  if (camera.mounting == CameraDifference::Mounting::other)
    prior.T = map_->camera.mounting->T_b_c().inverse() * view.camera->mounting->T_b_c();
  return prior;
}

Query GlobalLocalization::queryOf(const View& view, const CameraDifference& camera) const {
  if (camera.sameMounting()) return Query(view, on_floor_, of_floor_);
  const bool is_level = isLevelIn(view);
  return Query(view, priorOf(view, camera),
               is_level ? gravityInformation(view.gravity->down, view.gravity->std)
                        : Matrix6d(Matrix6d::Zero()));
}

// Is gravity known of the view and in the map?
bool GlobalLocalization::isLevelIn(const View& view) const {
  return view.gravity && !map_->models.empty() && gravityOf(view, 0, *map_->view(0));
}

// Gravity in the frame of a local model; nothing if it is unknown there, or for the view.
std::optional<Gravity> GlobalLocalization::gravityOf(const View& view, int model,
                                                     const View& of_model) const {
  if (!view.gravity || !view.gravity->valid()) return {};
  return shortlist_.gravity().of(model, of_model);
}

// May the view be of a camera turned about its optical axis?
bool GlobalLocalization::mayBeTurned(const Localization& answer) const {
  constexpr double kPoor = 0.5;  // probability of the first place
  const bool knows_no_better = answer.camera.mounting == CameraDifference::Mounting::unknown ||
                               answer.camera.mounting == CameraDifference::Mounting::not_in_map;
  return knows_no_better && answer.has_probabilities &&
         (answer.hypotheses.empty() || answer.hypotheses.front().probability < kPoor);
}

// Each model's list is written by its index, so that the answer does not depend on the number of threads.
void GlobalLocalization::registerWith(const Batch& batch, const Query& query, bool keeps_mean,
                                      std::vector<Hypothesis>& hypotheses) const {
  std::vector<std::vector<Hypothesis>> of_model(batch.size());
  forEachInParallel(static_cast<int>(batch.size()), threads_, [&](int i) {
    const auto& [model, start, is_aligned] = batch[i];
    const auto view = map_->view(model);
    const auto gravity = gravityOf(query.view, model, *view);
    if (!gravity) {
      of_model[i] = registration_.align(query, *view, start);
      return;
    }
    const Gravity& of_view = *query.view.gravity;
    Query for_model = query;
    for_model.prior = correctedByGravity(query.prior, *gravity, of_view, keeps_mean);
    if (!keeps_mean)  // else it stays the floor's, or empty
      for_model.known = gravityInformation(gravity->down, std::hypot(gravity->std, of_view.std));
    of_model[i] = registration_.align(for_model, *view, is_aligned ? start : for_model.prior);
  });
  const auto isAskedAnew = [&batch](const Hypothesis& h) {
    return std::binary_search(batch.begin(), batch.end(), Start{h.model, {}},
                              [](const Start& a, const Start& b) { return a.model < b.model; });
  };
  hypotheses.erase(std::remove_if(hypotheses.begin(), hypotheses.end(), isAskedAnew), hypotheses.end());
  for (std::size_t i = 0; i < batch.size(); ++i)
    for (Hypothesis& h : of_model[i]) {
      h.model = batch[i].model;
      const LocalModel& model = map_->models[h.model];
      h.part = model.part;
      if (model.T_w_m) h.T_w_c = *model.T_w_m * h.T_m_c.T;
      hypotheses.push_back(std::move(h));
    }
}

Localization GlobalLocalization::rank(const Query& query, std::vector<Hypothesis> hypotheses,
                                      PixelVerdicts& known) const {
  Localization answer;
  if (map_->models.empty()) answer.reason = "the map has no local model";
  if (query.view.segments.empty()) answer.reason = whyNoHypothesis(query, params_.tree);
  if (!answer.reason.empty()) return answer;

  answer.has_probabilities = registration_.score().inNats();
  answer.hypotheses = std::move(hypotheses);
  ranking_.rank(query.view, answer.hypotheses, known);
  if (answer.hypotheses.empty()) answer.reason = whyNoHypothesis(query, params_.tree);
  return answer;
}

// Is the first place so probable that no other need be asked?
bool GlobalLocalization::isSure(const Localization& answer) const {
  return !answer.hypotheses.empty() && answer.has_probabilities &&
         answer.hypotheses.front().probability >= params_.shortlist.sure_probability;
}

GlobalLocalization GlobalLocalization::without(std::function<bool(int)> absent) const {
  GlobalLocalization rest(*this);
  rest.ranking_.leaveOut(absent);
  rest.absent_ = std::move(absent);
  return rest;
}

// Upright first, and the other rolls only where that finds nothing.
Localization GlobalLocalization::localize(const View& view, const std::function<bool(int)>& excluded,
                                          std::optional<int>& quarters) const {
  const CameraDifference camera = differenceFrom(map_->camera, view);
  const bool is_level = isLevelIn(view);
  if (quarters.value_or(0) != 0 && !is_level)
    return search(Query(view, priorOfRoll(*quarters)), camera, excluded);
  Localization answer = search(queryOf(view, camera), camera, excluded);
  if (answer.state == AnswerState::sure) quarters = 0;
  if (quarters || is_level || !mayBeTurned(answer)) return answer;
  const bool shows_floor = showsFloor(view, Eigen::Isometry3d::Identity());
  for (int quarter = 1; quarter < 4; ++quarter) {
    if (shows_floor && !showsFloor(view, quarterTurns(quarter))) continue;
    // The right roll shows with the likeliest models; the others would cost as much as a whole search.
    Localization otherwise = search(Query(view, priorOfRoll(quarter)), camera, excluded, kByChance);
    const bool is_better = otherwise.state == AnswerState::sure &&
                           (answer.hypotheses.empty() || otherwise.hypotheses.front().score >
                                                             answer.hypotheses.front().score + kMuchBetter);
    if (!is_better) continue;
    answer = std::move(otherwise), quarters = quarter;
    discountTurned(answer);
  }
  return answer;
}

Localization GlobalLocalization::localize(const View& view) const {
  std::optional<int> quarters;
  Localization answer = localize(view, absent_, quarters);
  const PoseWithCovariance about =
      quarters.value_or(0) != 0 ? priorOfRoll(*quarters) : priorOf(view, answer.camera);
  const auto priorOfModel = [&](int model) {
    const auto of_model = view.gravity ? gravityOf(view, model, *map_->view(model)) : std::nullopt;
    return of_model ? correctedByGravity(about, *of_model, *view.gravity, answer.camera.sameMounting())
                    : about;
  };
  ranking_.stateAsShown(view, priorOfModel, answer.hypotheses);
  concludePose(params_.sure, answer);
  return answer;
}

Localization GlobalLocalization::search(const Query& query, const CameraDifference& camera,
                                        const std::function<bool(int)>& excluded, double promising) const {
  Localization answer;
  std::vector<Hypothesis> found;
  PixelVerdicts known;
  for (const NextBatch& next : shortlist_.batches(query, camera.sameMounting(), threads_, excluded)) {
    registerWith(next(bestScore(found)), query, camera.sameMounting(), found);
    answer = rank(query, found, known);
    if (isSure(answer) || bestScore(found) < promising) break;
  }
  answer.camera = camera;
  answer.decide();
  return answer;
}

Localization GlobalLocalization::localize(const View& view, const std::function<bool(int)>& excluded) const {
  const CameraDifference camera = differenceFrom(map_->camera, view);
  return search(queryOf(view, camera), camera, excluded);
}

std::optional<ViewShares> GlobalLocalization::shares(const View& view, const Localization& answer) const {
  if (answer.hypotheses.empty()) return {};
  return ranking_.shares(view, answer.hypotheses.front());
}

PoseWithCovariance GlobalLocalization::prior(const View& view) const {
  return priorOf(view, differenceFrom(map_->camera, view));
}

}  // namespace facetloc::internal
