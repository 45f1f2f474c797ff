// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/registration/global_localization.h>

#include <omp.h>

#include <algorithm>
#include <numeric>

namespace facetloc {

GlobalLocalization::GlobalLocalization(std::shared_ptr<const Map> map, const GlobalLocalizationParams& params,
                                       const SensorNoise& noise)
    : map_(std::move(map)),
      params_(params),
      registration_(params.registration, noise),
      ranking_(map_, params.ranking, params.registration.consensus, params.registration.depth,
               noise.inverse_depth_std) {
  prior_.P = posePrior(map_->mounting, params.prior);
  const PlaceIndexParams& index = params.index;
  if (index.shortlist > 0 && map_->mounting &&
      map_->models.size() > static_cast<std::size_t>(index.exhaustive_up_to))
    index_ = std::make_shared<PlaceIndex>(PlaceIndex::of(*map_, index, params.prior));
}

Localization GlobalLocalization::localize(const View& scene, const PoseWithCovariance& prior) const {
  return rank(scene, registerWith(candidates(scene), scene, prior));
}

std::vector<int> GlobalLocalization::candidates(const View& scene) const {
  std::vector<int> models;
  if (index_) models = index_->shortlist(scene, params_.index.shortlist);
  std::sort(models.begin(), models.end());  // as if the others had given no hypothesis
  if (models.empty()) {
    models.resize(map_->models.size());
    std::iota(models.begin(), models.end(), 0);
  }
  return models;
}

std::vector<Hypothesis> GlobalLocalization::registerWith(const std::vector<int>& models, const View& scene,
                                                         const PoseWithCovariance& prior) const {
  const int n = static_cast<int>(models.size());
  if (n == 0 || scene.segments.empty()) return {};
  // Each model's list is written by its index, so that the answer does not depend on the number of threads.
  const auto samples = samplePoints(scene);
  std::vector<std::vector<Hypothesis>> of_model(n);
  const int threads = std::min(n, threads_ > 0 ? threads_ : omp_get_num_procs());
#pragma omp parallel for schedule(dynamic) num_threads(threads) if (threads > 1)
  for (int i = 0; i < n; ++i)
    of_model[i] = registration_.align(scene, samples, *map_->view(models[i]), prior);

  std::vector<Hypothesis> hypotheses;
  for (int i = 0; i < n; ++i)
    for (Hypothesis& h : of_model[i]) {
      const LocalModel& model = map_->models[models[i]];
      h.model = models[i];
      if (model.T_w_m) h.T_w_c = *model.T_w_m * h.T_m_c.T;
      hypotheses.push_back(std::move(h));
    }
  return hypotheses;
}

Localization GlobalLocalization::rank(const View& scene, std::vector<Hypothesis> hypotheses) const {
  Localization answer;
  if (map_->models.empty()) answer.reason = "the map has no local model";
  if (scene.segments.empty()) answer.reason = "the view shows no planar segment";
  if (!answer.reason.empty()) return answer;

  answer.hypotheses = std::move(hypotheses);
  ranking_.rank(scene, answer.hypotheses);
  if (answer.hypotheses.empty()) {
    const HypothesisTreeParams& tree = params_.registration.tree;
    const std::string open =
        unconstrainedDirections(scene.segments, tree.complete_rotation_deg, tree.complete_translation);
    answer.reason =
        open.empty() ? "no local model agrees with the view" : "the planes in view leave free: " + open;
  }
  return answer;
}

}  // namespace facetloc
