// SPDX-License-Identifier: BSD-3-Clause
#include "shortlist/shortlist.h"

#include "threads/in_parallel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace facetloc::internal {
namespace {

constexpr double kNothing = std::numeric_limits<double>::lowest();  // score
constexpr double kStartRotationDeg = 3;  // heading error of a coarse alignment, standard deviation
constexpr int kFirstOverlays = 3;        // likeliest models that are first registered about their overlays
constexpr double kTiltOfPlanes = 2 * kDegree;  // deviation between planes and the gravity of models

/** The segments of a view in other axes. */
View turnedView(const View& seen, const Eigen::Isometry3d& T) {
  View view;
  for (const Segment& s : seen.segments) view.segments.push_back(transformed(s, T));
  return view;
}

// As if the models that are left out had given no hypothesis.
Batch byModel(Batch batch) {
  std::sort(batch.begin(), batch.end(), [](const Start& a, const Start& b) { return a.model < b.model; });
  return batch;
}

NextBatch asItIs(Batch batch) {
  return [batch = std::move(batch)](double) { return batch; };
}

}  // namespace

Shortlist::Shortlist(std::shared_ptr<const Map> map, const GlobalLocalizationParams& params)
    : map_(std::move(map)),
      params_(params),
      registration_(params),
      start_(params.prior),
      gravity_(std::make_shared<const MapGravity>(*map_)) {
  const ShortlistParams& shortlist = params.shortlist;
  start_.translation_std = shortlist.start_translation;
  start_.rotation_std_deg = kStartRotationDeg;
  const std::optional<CameraMounting>& mounting = map_->camera.mounting;
  PoseWithCovariance usual;
  usual.P = posePrior(mounting, params.prior);
  if (shortlist.size == 0 || map_->models.size() <= static_cast<std::size_t>(shortlist.exhaustive_up_to))
    return;
  if (mounting && PlaceIndex::covers(usual))
    index_ = std::make_shared<PlaceIndex>(PlaceIndex::of(*map_, shortlist, params.prior));
  planes_ = std::make_shared<std::array<LazyPlanes, 2>>();
}

// For a camera in the hand alone: a large map is opened without its views.
Shortlist::ModelPlanes Shortlist::readPlanes(bool levelled) const {
  ModelPlanes planes;
  planes.of_models.reserve(map_->models.size());
  for (std::size_t i = 0; i < map_->models.size(); ++i) {
    const auto view = map_->view(static_cast<int>(i));
    if (!levelled) {
      planes.of_models.emplace_back(*view);
      continue;
    }
    const auto down = gravity_->of(static_cast<int>(i), *view);
    if (!down) return {};
    planes.levelling.push_back(levelling(down->down));
    planes.of_models.emplace_back(turnedView(*view, Eigen::Isometry3d(planes.levelling.back())));
  }
  return planes;
}

const Shortlist::ModelPlanes& Shortlist::planes(bool levelled) const {
  LazyPlanes& lazy = (*planes_)[levelled];
  std::call_once(lazy.read, [&] { lazy.planes = readPlanes(levelled); });
  return lazy.planes;
}

std::vector<NextBatch> Shortlist::batches(const Query& query, bool on_floor, int threads,
                                          const std::function<bool(int)>& excluded) const {
  if (!registration_.mayFixPose(query)) return {asItIs({})};
  const ShortlistParams& p = params_.shortlist;
  std::vector<ShortlistedModel> models;
  if (index_ && on_floor)
    models = index_->candidates(query.view, std::max(p.examined_models, p.size), excluded);
  if (models.empty() && !on_floor) return overlaid(query, threads, excluded);
  if (models.empty()) return {asItIs(allModels(query, excluded))};
  const int first = std::min(p.first_models, p.size);
  Batch likeliest, others;
  for (const ShortlistedModel& c : models) {
    // Only the joint refinement estimates a pose without where it was looked for.
    const bool is_aligned = c.start && params_.steps.joint_refinement;
    (c.rank < first ? likeliest : others)
        .push_back(is_aligned ? Start{c.model, startAt(*c.start, map_->camera.mounting), true}
                              : Start{c.model, query.prior});
  }
  const int most = p.size - static_cast<int>(likeliest.size());
  std::vector<NextBatch> out = {asItIs(byModel(std::move(likeliest)))};
  if (!others.empty() && most > 0)
    out.push_back([this, &query, rest = std::move(others), most, threads](double reached) {
      return examined(query, rest, most, reached, threads);
    });
  return out;
}

// Many models are aligned as well by chance. Those with whom all planes and some pixels, next to the
// alignment, agree best, in a tenth of the time that registration takes.
Batch Shortlist::examined(const Query& query, const Batch& aligned, int most, double reached,
                          int threads) const {
  const int n = static_cast<int>(aligned.size());
  const bool has_gap = registration_.score().inNats();
  if (!has_gap && n <= most) return byModel(aligned);
  std::vector<double> score(aligned.size(), kNothing);
  forEachInParallel(n, threads, [&](int i) {
    if (!aligned[i].is_aligned) return;
    const auto found = registration_.alignFrom(aligned[i].T_m_c, query, *map_->view(aligned[i].model));
    if (found) score[i] = found->score;
  });
  std::vector<int> order(aligned.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&score](int a, int b) { return score[a] > score[b]; });
  Batch out;
  if (order.empty()) return out;
  const double best = std::max(reached, score[order.front()]);
  for (const int i : order) {
    const bool is_hopeless =
        has_gap && aligned[i].is_aligned && score[i] < best - params_.shortlist.examined_gap;
    if (static_cast<int>(out.size()) >= most) break;
    if (!is_hopeless) out.push_back(aligned[i]);
  }
  return byModel(std::move(out));
}

// About where they are laid over the view, models cost little, but overlays are not exact: a pose beside one
// is lost. A sure place among them is right; otherwise the likeliest models are registered once more, about
// the prior.
std::vector<NextBatch> Shortlist::overlaid(const Query& query, int threads,
                                           const std::function<bool(int)>& excluded) const {
  Batch all = allModels(query, excluded);
  const bool can_be_sure = registration_.score().inNats() && params_.steps.joint_refinement;
  if (!planes_ || !can_be_sure) return {asItIs(std::move(all))};
  // Overlays are near the identity: of a camera that is turned against the map's, as if it were not; where
  // gravity is known, of two that are level.
  const bool is_level = query.view.gravity && query.view.gravity->valid() && !planes(true).levelling.empty();
  const bool is_turned = !is_level && !query.prior.T.isApprox(Eigen::Isometry3d::Identity());
  Eigen::Isometry3d back = is_turned ? query.prior.T : Eigen::Isometry3d::Identity();
  if (is_level) back.linear() = levelling(query.view.gravity->down);
  const PlaneTripletMatcher scene(is_level || is_turned ? turnedView(query.view, back) : query.view,
                                  query.prior,
                                  is_level ? std::hypot(query.view.gravity->std, kTiltOfPlanes) : 0);
  if (!scene.isUseful()) return {asItIs(std::move(all))};
  const ModelPlanes& planes = this->planes(is_level);

  const ShortlistParams& p = params_.shortlist;
  constexpr int kBlock = 64;  // models that one thread takes at a time
  const int n = static_cast<int>(all.size());
  std::vector<Overlay> overlays(all.size());
  forEachInParallel((n + kBlock - 1) / kBlock, threads, [&](int block) {
    for (int i = block * kBlock; i < std::min(n, (block + 1) * kBlock); ++i)
      overlays[i] = scene.on(planes.of_models[all[i].model]);
  });
  std::vector<int> order(all.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return overlays[a].score > overlays[b].score; });

  const auto startOf = [&](const Overlay& overlay, int model) {
    Eigen::Isometry3d T(overlay.T_m_c.matrix().cast<double>());
    if (is_level) T = Eigen::Isometry3d(planes.levelling[model]).inverse() * T;
    return is_level || is_turned ? T * back : T;
  };
  const auto batchOf = [&](int first, int last, bool about_overlays) {
    Batch batch;
    for (int r = first; r < std::min(n, last); ++r) {
      const Overlay& overlay = overlays[order[r]];
      Start start = all[order[r]];
      if (about_overlays && overlay.exists() && p.start_translation > 0)
        start = {start.model, startAt(startOf(overlay, start.model), std::nullopt), true};
      batch.push_back(start);
    }
    return batch;
  };
  std::vector<NextBatch> batches;
  // Level overlays are so few that their results have no runners-up that would reveal a wrong match.
  if (!is_level) batches.push_back(asItIs(byModel(batchOf(0, kFirstOverlays, true))));
  batches.push_back(asItIs(byModel(batchOf(0, p.first_models, false))));
  Batch others = batchOf(p.first_models, p.overlaid_size, true);
  if (!others.empty())
    batches.push_back([this, &query, others = std::move(others), threads](double reached) mutable {
      // Where there is no overlay, not three planes agree: of use only if the place seems to be in the map.
      if (reached < kByChance)
        others.erase(
            std::remove_if(others.begin(), others.end(), [](const Start& s) { return !s.is_aligned; }),
            others.end());
      return examined(query, others, static_cast<int>(others.size()), reached, threads);
    });
  return batches;
}

PoseWithCovariance Shortlist::startAt(const Eigen::Isometry3d& T_m_c,
                                      const std::optional<CameraMounting>& mounting) const {
  return {T_m_c, posePrior(mounting, start_, T_m_c)};
}

Batch Shortlist::allModels(const Query& query, const std::function<bool(int)>& excluded) const {
  Batch models;
  for (int i = 0; i < static_cast<int>(map_->models.size()); ++i)
    if (!excluded || !excluded(i)) models.push_back({i, query.prior});
  return models;
}

}  // namespace facetloc::internal
