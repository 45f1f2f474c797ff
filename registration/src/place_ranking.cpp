// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/so3.h>
#include <facetloc/registration/place_ranking.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace facetloc {
namespace {

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

// What several models say about one world pose: all together about each pixel of the scene, and one by one
// about their own pixels, moved into the scene.
struct DepthEvidence {
  DepthAgreement of_scene, of_models;
  int pixels = 0;  // of the scene
};

DepthEvidence compareWithModels(const View& scene, const Map& map, const std::vector<int>& models,
                                const Eigen::Isometry3d& T_w_c, const DepthComparison& comparison) {
  DepthEvidence sum;
  std::vector<DepthJudge> judges;
  for (const int i : models) {
    const DepthPicture& depth = map.models[i].view.depth;
    const Eigen::Isometry3d T_m_c = map.models[i].T_w_m->inverse() * T_w_c;
    judges.emplace_back(comparison, scene.depth, depth, T_m_c);
    sum.of_models += comparison.compare(depth, scene.depth, T_m_c.inverse(), kCoarseColumns);
  }
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
      ++sum.pixels;
      if (judged == 0) continue;
      ++(contradict > agree ? sum.of_scene.contradict
         : agree > 0        ? sum.of_scene.agree
                            : sum.of_scene.occluded);
    }
  return sum;
}

double evidence(const DepthEvidence& depth, const ConsensusParams& consensus,
                const PlaceRankingParams& params) {
  const double agreement = depth.of_scene.agree / std::max(1.0, double(depth.pixels));
  const double hidden = depth.of_models.occluded / std::max(1.0, double(depth.of_models.judged()));
  return params.agreement_weight * agreement -
         params.occlusion_weight * std::log1p(hidden / consensus.free_space_share) +
         freeSpaceTerm(depth.of_scene, consensus) + freeSpaceTerm(depth.of_models, consensus);
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
                 const ConsensusParams& consensus, const PlaceRankingParams& params,
                 std::vector<Hypothesis>& hypotheses) {
  sortByScore(hypotheses);
  if (!params.multi_model || scene.depth.empty()) return false;
  const std::size_t n = std::min<std::size_t>(hypotheses.size(), params.evidence_hypotheses);
  bool any = false;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < n; ++i) {
    Hypothesis& h = hypotheses[i];
    if (!h.T_w_c) continue;
    const std::vector<int> models = nearestModels(map, *h.T_w_c, params.evidence_models);
    h.evidence = evidence(compareWithModels(scene, map, models, *h.T_w_c, comparison), consensus, params);
    any = any || !models.empty();
    least = std::min(least, h.evidence);
  }
  if (!any) return false;
  for (std::size_t i = n; i < hypotheses.size(); ++i) hypotheses[i].evidence = least;
  for (Hypothesis& h : hypotheses) h.score = h.consensus + h.evidence;
  return true;
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
