// SPDX-License-Identifier: BSD-3-Clause
#include "shortlist/shortlist.h"

#include "shared/in_parallel.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace facetloc::internal {
namespace {

/** The segments of a view as its camera would see them at the mean of the prior. */
View turnedBack(const Query& query) {
  View view;
  for (const Segment& s : query.view.segments) view.segments.push_back(transformed(s, query.prior.T));
  return view;
}

}  // namespace

Shortlist::Shortlist(std::shared_ptr<const Map> map, const GlobalLocalizationParams& params)
    : map_(std::move(map)), params_(params), registration_(params), start_(params.prior) {
  const ShortlistParams& shortlist = params.shortlist;
  start_.translation_std = shortlist.start_translation;
  start_.rotation_std_deg = shortlist.start_rotation_deg;
  const std::optional<CameraMounting>& mounting = map_->camera.mounting;
  PoseWithCovariance usual;
  usual.P = posePrior(mounting, params.prior);
  if (shortlist.size == 0 || map_->models.size() <= static_cast<std::size_t>(shortlist.exhaustive_up_to))
    return;
  if (mounting && PlaceIndex::covers(usual))
    index_ = std::make_shared<PlaceIndex>(PlaceIndex::of(*map_, shortlist, params.prior));
  planes_ = std::make_shared<Planes>();
}

// For a camera in the hand alone: a large map is opened without its views.
const std::vector<PlaneColumns>& Shortlist::planes() const {
  std::call_once(planes_->read, [this] {
    std::vector<PlaneColumns> of_models;
    of_models.reserve(map_->models.size());
    for (std::size_t i = 0; i < map_->models.size(); ++i)
      of_models.emplace_back(*map_->view(static_cast<int>(i)));
    planes_->of_models = std::move(of_models);
  });
  return planes_->of_models;
}

std::vector<Batch> Shortlist::batches(const Query& query, bool on_floor, int threads,
                                      const std::function<bool(int)>& excluded) const {
  if (!registration_.mayFixPose(query)) return {{}};
  std::vector<Candidate> models;
  if (index_ && on_floor) models = listed(query, threads, excluded);
  if (models.empty() && !on_floor) return overlaid(query, threads, excluded);
  if (models.empty()) return {allModels(query, excluded)};
  std::sort(models.begin(), models.end(),  // as if the others had given no hypothesis
            [](const Candidate& a, const Candidate& b) { return a.model < b.model; });
  // Only the joint refinement estimates a pose without where it was looked for.
  const bool from_starts = params_.steps.joint_refinement;
  std::vector<Batch> out(2);
  for (const Candidate& c : models)
    out[c.rank < params_.shortlist.first_models ? 0 : 1].push_back(
        {c.model, c.start && from_starts ? startAt(*c.start, map_->camera.mounting) : query.prior});
  if (out[1].empty()) out.pop_back();
  return out;
}

Batch Shortlist::batch(const Query& query, bool on_floor, int threads) const {
  if (!registration_.mayFixPose(query)) return {};
  std::vector<Candidate> models;
  if (index_ && on_floor && PlaceIndex::covers(query.prior)) models = listed(query, threads, {});
  if (models.empty()) return allModels(query, {});
  Batch out;
  for (const Candidate& c : models)
    out.push_back({c.model, query.prior});  // starts are what the map's prior leads to
  std::sort(out.begin(), out.end(), [](const Start& a, const Start& b) { return a.model < b.model; });
  return out;
}

// Where all models can be aligned, alignments tell enough. In larger maps many are aligned as well by chance.
std::vector<Candidate> Shortlist::listed(const Query& query, int threads,
                                         const std::function<bool(int)>& excluded) const {
  const ShortlistParams& p = params_.shortlist;
  const bool is_large = map_->models.size() > static_cast<std::size_t>(p.aligned_models);
  std::vector<Candidate> models =
      index_->candidates(query.view, is_large ? std::max(p.examined_models, p.size) : p.size, excluded);
  if (static_cast<int>(models.size()) <= p.size) return models;
  return examined(query, std::move(models), threads);
}

// Of the models that come after the best aligned, those with whom all planes and some pixels, next to the
// alignment, agree best.
std::vector<Candidate> Shortlist::examined(const Query& query, std::vector<Candidate> models,
                                           int threads) const {
  const ShortlistParams& p = params_.shortlist;
  const int n = static_cast<int>(models.size()), kept = std::min(p.first_models, p.size);
  std::vector<double> score(models.size(), std::numeric_limits<double>::lowest());  // by rank
  forEachInParallel(n - kept, threads, [&](int i) {
    const Candidate& c = models[kept + i];
    if (!c.start) return;
    const auto found =
        registration_.alignFrom(startAt(*c.start, map_->camera.mounting), query, *map_->view(c.model));
    if (found) score[c.rank] = found->score;
  });
  std::stable_sort(models.begin() + kept, models.end(), [&score](const Candidate& a, const Candidate& b) {
    return score[a.rank] > score[b.rank];
  });
  const double gap =
      registration_.score().inNats() ? p.examined_gap : std::numeric_limits<double>::infinity();
  const double best = score[models[kept].rank];
  const auto isHopeless = [&](const Candidate& c) { return score[c.rank] < best - gap; };
  models.erase(std::find_if(models.begin() + kept, models.begin() + p.size, isHopeless), models.end());
  for (std::size_t i = 0; i < models.size(); ++i) models[i].rank = static_cast<int>(i);
  return models;
}

// About where they are laid over the view, models cost little, but overlays are not exact: a pose beside one
// is lost. What is sure there is right; else the likeliest are asked once more, about the prior.
std::vector<Batch> Shortlist::overlaid(const Query& query, int threads,
                                       const std::function<bool(int)>& excluded) const {
  Batch all = allModels(query, excluded);
  const bool can_be_sure = registration_.score().inNats() && params_.steps.joint_refinement;
  // Overlays are near the identity: of a camera that is turned against the map's, as if it were not.
  const bool is_turned = !query.prior.T.isApprox(Eigen::Isometry3d::Identity());
  const PlaneOverlay scene(is_turned ? turnedBack(query) : query.view, query.prior);
  if (!planes_ || !can_be_sure || !scene.isUseful()) return {all};
  const std::vector<PlaneColumns>& of_models = planes();

  const ShortlistParams& p = params_.shortlist;
  constexpr int kBlock = 64;  // models that one thread takes at a time
  const int n = static_cast<int>(all.size());
  std::vector<Overlay> overlays(all.size());
  forEachInParallel((n + kBlock - 1) / kBlock, threads, [&](int block) {
    for (int i = block * kBlock; i < std::min(n, (block + 1) * kBlock); ++i)
      overlays[i] = scene.on(of_models[all[i].model]);
  });
  std::vector<int> order(all.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return overlays[a].score > overlays[b].score; });

  const auto startOf = [&](const Overlay& overlay) {
    const Eigen::Isometry3d T(overlay.T_m_c.matrix().cast<double>());
    return is_turned ? T * query.prior.T : T;
  };
  const auto batchOf = [&](int first, int last, bool about_overlays) {
    Batch batch;
    for (int r = first; r < std::min(n, last); ++r) {
      const Overlay& overlay = overlays[order[r]];
      batch.push_back(all[order[r]]);
      if (about_overlays && overlay.exists() && p.start_translation > 0)
        batch.back().T_m_c = startAt(startOf(overlay), std::nullopt);
    }
    std::sort(batch.begin(), batch.end(), [](const Start& a, const Start& b) { return a.model < b.model; });
    return batch;
  };
  std::vector<Batch> batches = {batchOf(0, p.overlaid_first, true), batchOf(0, p.first_models, false),
                                batchOf(p.first_models, p.overlaid_size, true)};
  if (batches.back().empty()) batches.pop_back();
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
