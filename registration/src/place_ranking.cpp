// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/so3.h>
#include <facetloc/registration/place_ranking.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace facetloc {
namespace {

// Log likelihood ratios of a pixel that agrees, contradicts, is hidden (METHOD_MEASURED 11.4 (6)).
const double kAgree = std::log(1.6), kContradict = std::log(0.05), kOccluded = std::log(0.5);
constexpr double kCoarsePixels = 4;  // pixels of the fine grid that one of the coarse grid stands for

// The models that look at about the same place, nearest first: metres + 1.5 m per radian of the viewing
// direction.
std::vector<int> nearestModels(const Map& map, const Eigen::Isometry3d& T_w_c, int n) {
  constexpr double kMetresPerRadian = 1.5, kMaxDistance = 2.5, kMaxAngle = 50 * kDegree;
  std::vector<std::pair<double, int>> near;
  for (std::size_t i = 0; i < map.models.size(); ++i) {
    const LocalModel& m = map.models[i];
    if (!m.T_w_m || m.view.depth.empty()) continue;
    const double distance = (m.T_w_m->translation() - T_w_c.translation()).norm();
    if (!(distance < kMaxDistance)) continue;
    const Eigen::Vector3d a = m.T_w_m->linear().col(2), b = T_w_c.linear().col(2);
    const double angle = std::atan2(a.cross(b).norm(), a.dot(b));
    if (angle < kMaxAngle) near.emplace_back(distance + kMetresPerRadian * angle, static_cast<int>(i));
  }
  std::sort(near.begin(), near.end());
  if (static_cast<int>(near.size()) > n) near.resize(n);
  std::vector<int> index;
  for (const auto& [cost, i] : near) index.push_back(i);
  return index;
}

// Evidence of several models for one world pose: each scene pixel is judged by all of them together, and each
// model's own pixels are moved into the scene.
double evidence(const View& scene, const Map& map, const std::vector<int>& models,
                const Eigen::Isometry3d& T_w_c, const DepthComparison& comparison) {
  std::vector<Eigen::Isometry3d> T_m_c;
  std::vector<DepthJudge> judges;
  for (const int i : models) {
    T_m_c.push_back(map.models[i].T_w_m->inverse() * T_w_c);
    judges.emplace_back(comparison, scene.depth, map.models[i].view.depth, T_m_c.back());
  }
  double sum = 0;
  const int step = gridStep(scene.depth, kFineColumns);
  for (int v = step / 2; v < scene.depth.camera.height; v += step)
    for (int u = step / 2; u < scene.depth.camera.width; u += step) {
      int agree = 0, contradict = 0, judged = 0;
      for (const DepthJudge& judge : judges) {
        const DepthVerdict verdict = judge(u, v);
        judged += verdict != DepthVerdict::outside;
        agree += verdict == DepthVerdict::agree;
        contradict += verdict == DepthVerdict::contradict;
      }
      if (judged) sum += contradict > agree ? kContradict : agree > 0 ? kAgree : kOccluded;
    }
  double reverse = 0;
  for (std::size_t k = 0; k < models.size(); ++k) {
    const DepthAgreement a =
        comparison.compare(map.models[models[k]].view.depth, scene.depth, T_m_c[k].inverse(), kCoarseColumns);
    reverse += kCoarsePixels * (a.agree * kAgree + a.contradict * kContradict + a.occluded * kOccluded);
  }
  return sum + reverse / std::max<std::size_t>(1, models.size());
}

void sortByScore(std::vector<Hypothesis>& h) {
  std::stable_sort(h.begin(), h.end(),
                   [](const Hypothesis& a, const Hypothesis& b) { return a.score > b.score; });
}

bool samePlace(const Hypothesis& a, const Hypothesis& b, const PlaceRankingParams& params) {
  if (!a.T_w_c || !b.T_w_c) return false;
  if ((a.T_w_c->translation() - b.T_w_c->translation()).norm() > params.merge_translation) return false;
  return rotationAngle(a.T_w_c->linear() * b.T_w_c->linear().transpose()) <=
         params.merge_rotation_deg * kDegree;
}

}  // namespace

bool addEvidence(const View& scene, const Map& map, const DepthComparison& comparison,
                 const PlaceRankingParams& params, std::vector<Hypothesis>& hypotheses) {
  sortByScore(hypotheses);
  if (!params.multi_model || scene.depth.empty()) return false;
  const std::size_t n = std::min<std::size_t>(hypotheses.size(), params.evidence_hypotheses);
  bool any = false;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < n; ++i) {
    Hypothesis& h = hypotheses[i];
    if (!h.T_w_c) continue;
    const std::vector<int> models = nearestModels(map, *h.T_w_c, params.evidence_models);
    h.evidence = params.evidence_weight * evidence(scene, map, models, *h.T_w_c, comparison);
    any = any || !models.empty();
    least = std::min(least, h.evidence);
  }
  for (std::size_t i = n; any && i < hypotheses.size(); ++i) hypotheses[i].evidence = least;
  for (Hypothesis& h : hypotheses) h.score += h.evidence;
  return any;
}

void rankPlaces(const PlaceRankingParams& params, bool with_evidence, std::vector<Hypothesis>& hypotheses) {
  sortByScore(hypotheses);
  if (params.merge) {
    std::vector<Hypothesis> places;
    for (Hypothesis& h : hypotheses) {
      const bool known = std::any_of(places.begin(), places.end(),
                                     [&](const Hypothesis& p) { return samePlace(p, h, params); });
      if (!known) places.push_back(std::move(h));
    }
    hypotheses.swap(places);
  }
  if (hypotheses.empty()) return;
  const double slope = with_evidence ? params.softmax_slope : params.plain_softmax_slope;
  const double null_score = with_evidence ? params.null_score : params.plain_null_score;
  const double largest = std::max(hypotheses.front().score, null_score);  // keeps the exponentials in range
  double sum = std::exp(slope * (null_score - largest));
  for (Hypothesis& h : hypotheses) sum += h.probability = std::exp(slope * (h.score - largest));
  for (Hypothesis& h : hypotheses) h.probability /= sum;
}

}  // namespace facetloc
