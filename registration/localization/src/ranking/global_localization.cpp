// SPDX-License-Identifier: BSD-3-Clause
#include "ranking/global_localization.h"

#include "pairs/mounting_check.h"
#include "pairs/view_registration.h"
#include "ranking/place_ranking.h"
#include "shortlist/shortlist.h"
#include "threads/in_parallel.h"

#include <facetloc/features/map_metadata.h>

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace facetloc {

using namespace internal;

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

struct GlobalLocalization::Impl {
  Impl(std::shared_ptr<const Map> the_map, const GlobalLocalizationParams& the_params);

  PoseWithCovariance priorOf(const View& view, const CameraDifference& camera) const;
  Query queryOf(const View& view, const CameraDifference& camera) const;
  PoseWithCovariance priorOfRoll(int quarters) const { return {quarterTurns(quarters), anywhere.P}; }
  bool isLevelIn(const View& view) const;
  std::optional<Gravity> gravityOf(const View& view, int model, const View& of_model) const;
  bool mayBeTurned(const Localization& answer) const;
  void registerWith(const Batch& batch, const Query& query, bool keeps_mean,
                    std::vector<Hypothesis>& hypotheses) const;
  void stateAsShown(const View& view, const PoseWithCovariance& prior, bool keeps_mean,
                    std::vector<Hypothesis>& hypotheses) const;
  Localization rank(const Query& query, std::vector<Hypothesis> hypotheses, ComparedAndRefined& known) const;
  Localization localize(const Query& query, const CameraDifference& camera,
                        const std::function<bool(int)>& excluded, double promising = kLowest) const;
  Localization localizeAtAnyRoll(const View& view, const CameraDifference& camera,
                                 const std::function<bool(int)>& excluded,
                                 std::optional<int>& quarters) const;
  bool isSure(const Localization& answer) const;

  std::shared_ptr<const Map> map;
  GlobalLocalizationParams params;
  ViewRegistration registration;
  Shortlist shortlist;
  PlaceRanking ranking;
  PoseWithCovariance on_floor, anywhere;  // priors of a camera mounted as the map's, and of any other
  Matrix6d of_floor = Matrix6d::Zero();   // information of the floor about a pose
  int threads = 1;
  std::function<bool(int)> absent;  // local models of the map that count as missing; may be empty
};

GlobalLocalization::Impl::Impl(std::shared_ptr<const Map> the_map, const GlobalLocalizationParams& the_params)
    : map(std::move(the_map)),
      params(paramsFor(*map, checked(the_params))),
      registration(params),
      shortlist(map, params),
      ranking(map, params) {
  on_floor.P = posePrior(map->camera.mounting, params.prior);
  anywhere.P = posePrior({}, params.prior);
  if (params.steps.floor_information) of_floor = floorInformation(map->camera.mounting, params.prior);
}

// Prior for cameras with different mountings, about the difference of both.
PoseWithCovariance GlobalLocalization::Impl::priorOf(const View& view, const CameraDifference& camera) const {
  if (camera.sameMounting()) return on_floor;
  PoseWithCovariance prior = anywhere;
  if (camera.mounting == CameraDifference::Mounting::other)
    prior.T = map->camera.mounting->T_b_c().inverse() * view.camera->mounting->T_b_c();
  return prior;
}

Query GlobalLocalization::Impl::queryOf(const View& view, const CameraDifference& camera) const {
  if (camera.sameMounting()) return Query(view, on_floor, of_floor);
  const bool is_level = isLevelIn(view);
  return Query(view, priorOf(view, camera),
               is_level ? gravityInformation(view.gravity->down, view.gravity->std)
                        : Matrix6d(Matrix6d::Zero()));
}

// Is gravity known of the view and in the map?
bool GlobalLocalization::Impl::isLevelIn(const View& view) const {
  return view.gravity && !map->models.empty() && gravityOf(view, 0, *map->view(0));
}

// Gravity in the frame of a local model; nothing if it is unknown there, or for the view.
std::optional<Gravity> GlobalLocalization::Impl::gravityOf(const View& view, int model,
                                                           const View& of_model) const {
  if (!view.gravity || !view.gravity->valid()) return {};
  return shortlist.gravity().of(model, of_model);
}

// May the view be of a camera turned about its optical axis?
bool GlobalLocalization::Impl::mayBeTurned(const Localization& answer) const {
  constexpr double kPoor = 0.5;  // probability of the first place
  const bool knows_no_better = answer.camera.mounting == CameraDifference::Mounting::unknown ||
                               answer.camera.mounting == CameraDifference::Mounting::not_in_map;
  return knows_no_better && answer.has_probabilities &&
         (answer.hypotheses.empty() || answer.hypotheses.front().probability < kPoor);
}

// Each model's list is written by its index, so that the answer does not depend on the number of threads.
void GlobalLocalization::Impl::registerWith(const Batch& batch, const Query& query, bool keeps_mean,
                                            std::vector<Hypothesis>& hypotheses) const {
  std::vector<std::vector<Hypothesis>> of_model(batch.size());
  forEachInParallel(static_cast<int>(batch.size()), threads, [&](int i) {
    const auto& [model, start, is_aligned] = batch[i];
    const auto view = map->view(model);
    const auto gravity = gravityOf(query.view, model, *view);
    if (!gravity) {
      of_model[i] = registration.align(query, *view, start);
      return;
    }
    const Query for_model = levelledFor(query, *gravity, keeps_mean);
    of_model[i] = registration.align(for_model, *view, is_aligned ? start : for_model.prior);
  });
  const auto isAskedAnew = [&batch](const Hypothesis& h) {
    return std::binary_search(batch.begin(), batch.end(), Start{h.model, {}},
                              [](const Start& a, const Start& b) { return a.model < b.model; });
  };
  hypotheses.erase(std::remove_if(hypotheses.begin(), hypotheses.end(), isAskedAnew), hypotheses.end());
  for (std::size_t i = 0; i < batch.size(); ++i)
    for (Hypothesis& h : of_model[i]) {
      h.model = batch[i].model;
      const LocalModel& model = map->models[h.model];
      h.part = model.part;
      if (model.T_w_m) h.T_w_c = *model.T_w_m * h.T_m_c.T;
      hypotheses.push_back(std::move(h));
    }
}

Localization GlobalLocalization::Impl::rank(const Query& query, std::vector<Hypothesis> hypotheses,
                                            ComparedAndRefined& known) const {
  Localization answer;
  if (map->models.empty()) answer.reason = "the map has no local model";
  if (query.view.segments.empty()) answer.reason = whyNoHypothesis(query, params.tree);
  if (!answer.reason.empty()) return answer;

  answer.has_probabilities = registration.score().inNats();
  answer.hypotheses = std::move(hypotheses);
  ranking.rank(query.view, answer.hypotheses, known);
  if (answer.hypotheses.empty()) answer.reason = whyNoHypothesis(query, params.tree);
  return answer;
}

// Is the first place so probable that no other need be asked?
bool GlobalLocalization::Impl::isSure(const Localization& answer) const {
  return !answer.hypotheses.empty() && answer.has_probabilities &&
         answer.hypotheses.front().probability >= params.shortlist.sure_probability;
}

GlobalLocalization::GlobalLocalization(std::shared_ptr<const Map> map, const GlobalLocalizationParams& params)
    : impl_(std::make_unique<Impl>(std::move(map), params)) {}
GlobalLocalization::GlobalLocalization(const GlobalLocalization& other)
    : impl_(std::make_unique<Impl>(*other.impl_)) {}
GlobalLocalization::GlobalLocalization(GlobalLocalization&&) noexcept = default;
GlobalLocalization& GlobalLocalization::operator=(GlobalLocalization&&) noexcept = default;
GlobalLocalization::~GlobalLocalization() = default;

const Map& GlobalLocalization::map() const { return *impl_->map; }
void GlobalLocalization::setNumberOfThreads(int n) { impl_->threads = n; }

GlobalLocalization GlobalLocalization::without(std::function<bool(int)> absent) const {
  GlobalLocalization rest(*this);
  rest.impl_->ranking.leaveOut(absent);
  rest.impl_->absent = std::move(absent);
  return rest;
}

// Upright first, and the other rolls only where that finds nothing.
Localization GlobalLocalization::Impl::localizeAtAnyRoll(const View& view, const CameraDifference& camera,
                                                         const std::function<bool(int)>& excluded,
                                                         std::optional<int>& quarters) const {
  const bool is_level = isLevelIn(view);
  if (quarters.value_or(0) != 0 && !is_level)
    return localize(Query(view, priorOfRoll(*quarters)), camera, excluded);
  Localization answer = localize(queryOf(view, camera), camera, excluded);
  if (answer.state == AnswerState::sure) quarters = 0;
  if (quarters || is_level || !mayBeTurned(answer)) return answer;
  const bool shows_floor = showsFloor(view, Eigen::Isometry3d::Identity());
  for (int quarter = 1; quarter < 4; ++quarter) {
    if (shows_floor && !showsFloor(view, quarterTurns(quarter))) continue;
    // The right roll shows with the likeliest models; the others would cost as much as a whole search.
    Localization otherwise = localize(Query(view, priorOfRoll(quarter)), camera, excluded, kByChance);
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
  const CameraDifference camera = differenceFrom(impl_->map->camera, view);
  std::optional<int> quarters;
  Localization answer = impl_->localizeAtAnyRoll(view, camera, impl_->absent, quarters);
  const PoseWithCovariance about =
      quarters.value_or(0) != 0 ? impl_->priorOfRoll(*quarters) : impl_->priorOf(view, camera);
  impl_->stateAsShown(view, about, camera.sameMounting(), answer.hypotheses);
  concludePose(impl_->params.sure, answer);
  return answer;
}

void GlobalLocalization::Impl::stateAsShown(const View& view, const PoseWithCovariance& prior,
                                            bool keeps_mean, std::vector<Hypothesis>& hypotheses) const {
  const auto priorOfModel = [&](int model) {
    const auto of_model = view.gravity ? gravityOf(view, model, *map->view(model)) : std::nullopt;
    return of_model ? correctedByGravity(prior, *of_model, *view.gravity, keeps_mean) : prior;
  };
  ranking.stateAsShown(view, priorOfModel, hypotheses);
}

Localization GlobalLocalization::Impl::localize(const Query& query, const CameraDifference& camera,
                                                const std::function<bool(int)>& excluded,
                                                double promising) const {
  Localization answer;
  std::vector<Hypothesis> found;
  ComparedAndRefined known;
  for (const NextBatch& next : shortlist.batches(query, camera.sameMounting(), threads, excluded)) {
    registerWith(next(bestScore(found)), query, camera.sameMounting(), found);
    answer = rank(query, found, known);
    if (isSure(answer) || bestScore(found) < promising) break;
  }
  answer.camera = camera;
  answer.decide();
  return answer;
}

Localization GlobalLocalization::localize(const View& view, const std::function<bool(int)>& excluded) const {
  const CameraDifference camera = differenceFrom(impl_->map->camera, view);
  return impl_->localize(impl_->queryOf(view, camera), camera, excluded);
}

Localization GlobalLocalization::localize(const View& view, const std::function<bool(int)>& excluded,
                                          std::optional<int>& quarters) const {
  return impl_->localizeAtAnyRoll(view, differenceFrom(impl_->map->camera, view), excluded, quarters);
}

Localization GlobalLocalization::localize(const View& view, const PoseWithCovariance& prior) const {
  const CameraDifference camera = differenceFrom(impl_->map->camera, view);
  const bool on_floor = camera.sameMounting();
  Localization answer;
  if (prior.P.allFinite() && Eigen::LLT<Matrix6d>(prior.P).info() == Eigen::Success) {
    const Query query(view, prior, on_floor ? impl_->of_floor : Matrix6d(Matrix6d::Zero()));
    std::vector<Hypothesis> found;
    impl_->registerWith(impl_->shortlist.batch(query, on_floor, impl_->threads), query, true, found);
    ComparedAndRefined nothing;
    answer = impl_->rank(query, std::move(found), nothing);
    impl_->stateAsShown(view, prior, true, answer.hypotheses);
    concludePose(impl_->params.sure, answer);
  } else {
    answer.reason = "the covariance of the prior is not positive definite";
  }
  answer.camera = camera;
  return answer;
}

std::optional<ViewShares> GlobalLocalization::shares(const View& view, const Localization& answer) const {
  if (answer.hypotheses.empty()) return {};
  return impl_->ranking.shares(view, answer.hypotheses.front());
}

PoseWithCovariance GlobalLocalization::prior(const View& view) const {
  return impl_->priorOf(view, differenceFrom(impl_->map->camera, view));
}

}  // namespace facetloc
