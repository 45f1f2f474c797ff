// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/map_ambiguity.h"

#include "nearby/nearby_models.h"
#include "poses/pose_fusion.h"
#include "threads/in_parallel.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace facetloc::internal {
namespace {

constexpr std::size_t kMostViews = 200;
constexpr std::size_t kMostRegistrations = 400000;  // where every model is registered with every view

constexpr int kPictures = 5;       // local models around a view, as in an answer
constexpr double kTail = 4;        // degrees of freedom of Student's distribution of the errors
constexpr double kPrior = 1;       // standard deviation of the logarithm of each size between cameras
constexpr double kSettled = 0.02;  // step of the logarithms

/** Logarithms of the three sizes, relative to the usual ones. */
using Sizes = Eigen::Vector3d;

ConsideredErrors scaled(const Sizes& by) {
  ConsideredErrors errors;
  errors.pixels_as_one *= std::exp(by[0]);
  errors.rotation_std *= std::exp(by[1]);
  errors.translation_std *= std::exp(by[2]);
  return errors;
}

// Minus the log likelihood of the views and the prior. The errors of a view and of its surroundings, both of
// that size, are in a realignment. The covariance of Student's distribution is wider than its scale.
double cost(const std::vector<RealignedView>& views, const Sizes& sizes) {
  constexpr double kScale = (kTail - 2) / kTail;
  static const Matrix6d of_start = symmetricInverse(aboutStart());
  const ConsideredErrors errors = scaled(sizes);
  double sum = sizes.squaredNorm() / (2 * kPrior * kPrior);
  for (const RealignedView& view : views) {
    const Matrix6d of_pixels = symmetricInverse(of_start + view.information / errors.pixels_as_one);
    const Matrix6d P = withSharedErrors(of_pixels, std::sqrt(2) * errors.rotation_std,
                                        std::sqrt(2) * errors.translation_std);
    const Eigen::LLT<Matrix6d> factor(kScale * P);
    const double squared = view.error.dot(factor.solve(view.error));
    sum +=
        factor.matrixLLT().diagonal().array().log().sum() + 0.5 * (kTail + 6) * std::log1p(squared / kTail);
  }
  return sum;
}

std::optional<RealignedView> realigned(const Map& map, const NearbyModels& near,
                                       const std::vector<char>& rendered, int model) {
  const LocalModel& own = map.models[model];
  std::vector<std::shared_ptr<const View>> around;
  std::vector<PosedPicture> pictures;
  for (const int i : near.bySight(own.part, *own.T_w_m, kEvidenceReach, kPictures + 1)) {
    if (i == model || rendered[i] || pictures.size() == kPictures) continue;
    around.push_back(map.view(i));
    pictures.push_back({&around.back()->depth, *map.models[i].T_w_m});
  }
  RealignedView view;
  PoseWithCovariance pose{*own.T_w_m, aboutStart()};
  if (!refineByDepth(map.view(model)->depth, pictures, {}, pose, &view.information)) return {};
  view.error = boxminus(*own.T_w_m, pose.T);
  return view;
}

}  // namespace

std::vector<int> viewsToAsk(const Map& map) {
  const std::vector<char> rendered = renderedViews(map);
  std::vector<int> models;
  for (std::size_t i = 0; i < map.models.size(); ++i)
    if (map.models[i].T_w_m && map.models[i].hasPicture() && !rendered[i])
      models.push_back(static_cast<int>(i));
  const std::size_t most =
      map.camera.mounting ? kMostViews : std::min(kMostViews, kMostRegistrations / (1 + models.size()));
  if (models.size() <= most) return models;
  std::vector<int> some;
  for (std::size_t i = 0; i < most; ++i) some.push_back(models[i * models.size() / most]);
  return some;
}

double reachOfSurroundings(const Map& map, int part) {
  constexpr double kFarthest = 3;  // [m]
  Eigen::AlignedBox3d extent;
  for (const LocalModel& model : map.models)
    if (model.T_w_m && model.part == part) extent.extend(model.T_w_m->translation());
  return extent.isEmpty() ? kFarthest : std::min(kFarthest, extent.diagonal().norm() / 3);
}

std::optional<Hypothesis> wrongPlace(const GlobalLocalization& localization, int model,
                                     const std::function<bool(int)>& excluded) {
  const Map& map = localization.map();
  const Eigen::Isometry3d& T_w_m = *map.models[model].T_w_m;
  const int part = map.models[model].part;
  const double reach = reachOfSurroundings(map, part);
  const auto isNearOrExcluded = [&](int i) {  // or may be, for all that is known
    const auto& T = map.models[i].T_w_m;
    return !T || map.models[i].part != part || (T->translation() - T_w_m.translation()).norm() <= reach ||
           (excluded && excluded(i));
  };
  View view = *map.view(model);
  if (!view.camera) view.camera = std::make_shared<const Camera>(map.camera);
  Localization answer = localization.localize(view, isNearOrExcluded);
  for (Hypothesis& h : answer.hypotheses)
    if (h.T_w_c && !internal::kSameSurroundings.joins(*h.T_w_c, T_w_m)) return std::move(h);
  return {};
}

std::optional<MapAmbiguity> ambiguityOf(const AliasScores& scores) {
  std::vector<double> found;
  for (const std::optional<double>& score : scores)
    if (score) found.push_back(*score);
  if (found.empty()) return {};
  const std::size_t tenth = (found.size() + 9) / 10;
  const auto end = found.begin() + static_cast<std::ptrdiff_t>(tenth);
  std::partial_sort(found.begin(), end, found.end(), std::greater<>());
  return MapAmbiguity{std::accumulate(found.begin(), end, 0.0) / static_cast<double>(tenth),
                      static_cast<int>(found.size())};
}

void setAmbiguity(const AliasScores& scores, Map& map) {
  map.ambiguity = ambiguityOf(scores);
  for (std::size_t i = 0; i < map.models.size(); ++i) map.models[i].alias_score = scores[i];
}

std::vector<RealignedView> realignedViews(const std::shared_ptr<const Map>& map, int threads) {
  const NearbyModels near(map, true);
  const std::vector<char> rendered = renderedViews(*map);
  const std::vector<int> models = viewsToAsk(*map);
  std::vector<std::optional<RealignedView>> found(models.size());
  forEachInParallel(static_cast<int>(models.size()), threads,
                    [&](int i) { found[i] = realigned(*map, near, rendered, models[i]); });
  std::vector<RealignedView> all;
  for (const auto& view : found)
    if (view) all.push_back(*view);
  return all;
}

// Steps along each size in turn, to both sides, half as long once none is better.
ConsideredErrors consideredErrors(const std::vector<RealignedView>& views) {
  Sizes best = Sizes::Zero();
  double least = cost(views, best);
  for (double step = 1; step > kSettled;) {
    bool is_better = false;
    for (int k = 0; k < 3; ++k)
      for (const double sign : {-1.0, 1.0}) {
        Sizes sizes = best;
        sizes[k] += sign * step;
        const double there = cost(views, sizes);
        if (!(there < least)) continue;
        best = sizes, least = there, is_better = true;
      }
    if (!is_better) step /= 2;
  }
  ConsideredErrors errors = scaled(best);
  errors.views = static_cast<int>(views.size());
  return errors;
}

}  // namespace facetloc::internal
