// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/registration/global_localization.h>

#include <Eigen/Cholesky>
#include <omp.h>

#include <algorithm>
#include <exception>
#include <iterator>
#include <limits>

namespace facetloc {
namespace {

// Is the first place so probable that no other need be asked? Probabilities by surface scores mean nothing.
bool isSure(const Localization& answer, const GlobalLocalizationParams& params) {
  return !params.registration.consensus.surface_score && !answer.hypotheses.empty() &&
         answer.hypotheses.front().probability >= params.index.sure_probability;
}

/** Calls a function with 0 .. n - 1. What is thrown does not depend on the number of threads. */
template <class Function>
void forEach(int n, int threads, const Function& function) {
  std::vector<std::exception_ptr> failure(static_cast<std::size_t>(n));
  const int used = std::min(n, threads > 0 ? threads : omp_get_num_procs());
#pragma omp parallel for schedule(dynamic) num_threads(used) if (used > 1)
  for (int i = 0; i < n; ++i) try {
      function(i);
    } catch (...) {
      failure[i] = std::current_exception();
    }
  for (const std::exception_ptr& f : failure)
    if (f) std::rethrow_exception(f);
}

void append(std::vector<Hypothesis>&& some, std::vector<Hypothesis>& all) {
  std::move(some.begin(), some.end(), std::back_inserter(all));
}

}  // namespace

GlobalLocalization::GlobalLocalization(std::shared_ptr<const Map> map, const GlobalLocalizationParams& params,
                                       const SensorNoise& noise)
    : map_(std::move(map)),
      params_(checked(params)),
      registration_(params.registration, noise, floorInformation(map_->mounting, params.prior)),
      ranking_(map_, params.ranking, params.registration.consensus, params.registration.depth,
               noise.inverse_depth_std) {
  prior_.P = posePrior(map_->mounting, params.prior);
  const PlaceIndexParams& index = params.index;
  start_ = params.prior;
  start_.translation_std = index.start_translation;
  start_.rotation_std_deg = index.start_rotation_deg;
  if (index.shortlist > 0 && map_->mounting && PlaceIndex::covers(prior_) &&
      map_->models.size() > static_cast<std::size_t>(index.exhaustive_up_to))
    index_ = std::make_shared<PlaceIndex>(PlaceIndex::of(*map_, index, params.prior));
}

Localization GlobalLocalization::localize(const View& scene) const {
  return localizeBy([&](const std::vector<Candidate>& c) { return registerWith(c, scene, prior_); }, scene);
}

Localization GlobalLocalization::localizeBy(const Registering& registerAll, const View& scene) const {
  const std::vector<Candidate> models = candidates(scene);
  std::vector<Candidate> first, others;
  for (const Candidate& c : models) (c.rank < params_.index.first_models ? first : others).push_back(c);
  std::vector<Hypothesis> hypotheses = registerAll(first);
  Localization answer = rank(scene, hypotheses);
  if (others.empty() || isSure(answer, params_)) return answer;
  append(registerAll(others), hypotheses);
  return rank(scene, std::move(hypotheses));
}

Localization GlobalLocalization::localize(const View& scene, const PoseWithCovariance& prior) const {
  if (!prior.P.allFinite() || Eigen::LLT<Matrix6d>(prior.P).info() != Eigen::Success) {
    Localization answer;
    answer.reason = "the covariance of the prior is not positive definite";
    return answer;
  }
  std::vector<Candidate> models = PlaceIndex::covers(prior) ? candidates(scene) : allModels();
  for (Candidate& c : models) c.start.reset();  // they are what this map's prior leads to
  return rank(scene, registerWith(models, scene, prior));
}

std::vector<Candidate> GlobalLocalization::candidates(const View& scene) const {
  std::vector<Candidate> models;
  if (index_) models = shortlist(scene);
  std::sort(models.begin(), models.end(),  // as if the others had given no hypothesis
            [](const Candidate& a, const Candidate& b) { return a.model < b.model; });
  return models.empty() ? allModels() : models;
}

// Where all models can be aligned, alignments tell enough. In larger maps many are aligned as well by chance:
// of those that come after the best, with whom all planes and some pixels, next to the alignment, agree best.
std::vector<Candidate> GlobalLocalization::shortlist(const View& scene) const {
  const PlaceIndexParams& index = params_.index;
  const int listed = index.shortlist, kept = std::min(index.first_models, listed);
  const bool is_large = map_->models.size() > static_cast<std::size_t>(index.aligned_models);
  std::vector<Candidate> models =
      index_->candidates(scene, is_large ? std::max(index.examined_models, listed) : listed);
  const int n = static_cast<int>(models.size());
  if (n <= listed) return models;

  const auto samples = samplePoints(scene);
  std::vector<double> score(models.size(), std::numeric_limits<double>::lowest());  // by rank
  forEach(n - kept, threads_, [&](int i) {
    const Candidate& c = models[kept + i];
    if (!c.start) return;
    const auto found = registration_.alignFrom(startOf(c), scene, samples, *map_->view(c.model));
    if (found) score[c.rank] = found->score;
  });
  std::stable_sort(models.begin() + kept, models.end(), [&score](const Candidate& a, const Candidate& b) {
    return score[a.rank] > score[b.rank];
  });
  const double best = score[models[kept].rank], gap = params_.registration.consensus.surface_score
                                                          ? std::numeric_limits<double>::infinity()
                                                          : index.examined_gap;
  const auto isHopeless = [&](const Candidate& c) { return score[c.rank] < best - gap; };
  models.erase(std::find_if(models.begin() + kept, models.begin() + listed, isHopeless), models.end());
  for (std::size_t i = 0; i < models.size(); ++i) models[i].rank = static_cast<int>(i);
  return models;
}

PoseWithCovariance GlobalLocalization::startOf(const Candidate& c) const {
  return {*c.start, posePrior(map_->mounting, start_, *c.start)};
}

std::vector<Candidate> GlobalLocalization::allModels() const {
  std::vector<Candidate> models(map_->models.size());
  for (std::size_t i = 0; i < models.size(); ++i) models[i].model = static_cast<int>(i);
  return models;
}

std::vector<Hypothesis> GlobalLocalization::registerWith(const std::vector<Candidate>& candidates,
                                                         const View& scene,
                                                         const PoseWithCovariance& prior) const {
  const int n = static_cast<int>(candidates.size());
  if (n == 0 || !registration_.mayFixPose(scene)) return {};
  // Each model's list is written by its index, so that the answer does not depend on the number of threads.
  const auto samples = samplePoints(scene);
  std::vector<std::vector<Hypothesis>> of_model(n);
  // Only the joint refinement estimates a pose without where it was looked for.
  const bool from_starts = params_.registration.joint_refinement;
  forEach(n, threads_, [&](int i) {
    const Candidate& c = candidates[i];
    of_model[i] = registration_.align(scene, samples, *map_->view(c.model), prior,
                                      c.start && from_starts ? startOf(c) : prior);
  });

  std::vector<Hypothesis> hypotheses;
  for (int i = 0; i < n; ++i)
    for (Hypothesis& h : of_model[i]) {
      h.model = candidates[i].model;
      const LocalModel& model = map_->models[h.model];
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
    const std::string open = unconstrainedDirections(scene.segments, tree.complete_rotation_deg,
                                                     tree.complete_translation, registration_.known());
    answer.reason =
        open.empty() ? "no local model agrees with the view" : "the planes in view leave free: " + open;
  }
  return answer;
}

}  // namespace facetloc
