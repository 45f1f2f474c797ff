// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/so3.h>
#include <facetloc/registration/place_ranking.h>
#include <facetloc/registration/view_alignment.h>

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
  DepthAgreement of_scene;
  int pixels = 0;  // of the scene
  std::vector<DepthAgreement> of_models;
};

DepthEvidence compareWithModels(const View& scene, const Map& map, const std::vector<int>& models,
                                const Eigen::Isometry3d& T_w_c, const DepthComparison& comparison) {
  DepthEvidence found;
  std::vector<PosedPicture> pictures;
  for (const int i : models) {
    const DepthPicture& depth = map.models[i].view.depth;
    const Eigen::Isometry3d T_m_c = map.models[i].T_w_m->inverse() * T_w_c;
    pictures.push_back({&depth, *map.models[i].T_w_m});
    found.of_models.push_back(comparison.compare(depth, scene.depth, T_m_c.inverse(), kCoarseColumns));
  }
  found.of_scene = compareWithAll(scene.depth, T_w_c, pictures, comparison, kFineColumns);
  const int step = gridStep(scene.depth, kFineColumns), first = step / 2;
  const auto onGrid = [&](int size) { return size > first ? (size - first - 1) / step + 1 : 0; };
  found.pixels = onGrid(scene.depth.camera.width) * onGrid(scene.depth.camera.height);
  return found;
}

double evidence(const DepthEvidence& found, const ConsensusParams& consensus,
                const PlaceRankingParams& params) {
  const auto tail = [&](double share) { return std::log1p(share / consensus.free_space_share); };
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

void sortByScore(std::vector<Hypothesis>& h) {
  std::stable_sort(h.begin(), h.end(),
                   [](const Hypothesis& a, const Hypothesis& b) { return a.score > b.score; });
}

bool samePlace(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, const PlaceRankingParams& params) {
  return (a.translation() - b.translation()).norm() <= params.merge_translation &&
         rotationAngle(a.linear() * b.linear().transpose()) <= params.merge_rotation_deg * kDegree;
}

bool samePlace(const Hypothesis& a, const Hypothesis& b, const PlaceRankingParams& params) {
  return a.T_w_c && b.T_w_c && samePlace(*a.T_w_c, *b.T_w_c, params);
}

// Moves a hypothesis, within its place, to where the pixels of these models fit best.
void refine(const View& scene, const Map& map, const std::vector<int>& models, double inverse_depth_std,
            const PlaceRankingParams& params, Hypothesis& h) {
  std::vector<PosedPicture> pictures;
  for (const int m : models) pictures.push_back({&map.models[m].view.depth, *map.models[m].T_w_m});
  const Eigen::Isometry3d& T_w_m = *map.models[h.model].T_w_m;
  Matrix6d rotation = Matrix6d::Zero();  // of the covariance into the world's axes
  rotation.topLeftCorner<3, 3>() = rotation.bottomRightCorner<3, 3>() = T_w_m.linear();
  PoseWithCovariance pose{*h.T_w_c, rotation * h.T_m_c.P * rotation.transpose()};
  if (!refineByDepth(scene.depth, pictures, inverse_depth_std, params.dense, pose)) return;
  if (!samePlace(*h.T_w_c, pose.T, params)) return;  // that is no refinement: planes found another place
  h.T_w_c = pose.T;
  h.T_m_c.T = T_w_m.inverse() * pose.T;
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
  std::vector<double> found(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const Hypothesis& h = hypotheses[i];
    if (!h.T_w_c) continue;
    const std::vector<int> models = nearestModels(map, *h.T_w_c, params.evidence_models);
    found[i] = evidence(compareWithModels(scene, map, models, *h.T_w_c, comparison), consensus, params);
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

void mergePlaces(const PlaceRankingParams& params, std::vector<Hypothesis>& hypotheses) {
  sortByScore(hypotheses);
  if (!params.merge) return;
  std::vector<Hypothesis> places;
  for (Hypothesis& h : hypotheses) {
    const bool known = std::any_of(places.begin(), places.end(),
                                   [&](const Hypothesis& p) { return samePlace(p, h, params); });
    if (!known) places.push_back(std::move(h));
  }
  hypotheses.swap(places);
}

void refinePlaces(const View& scene, const Map& map, const DepthConsistencyParams& depth,
                  double inverse_depth_std, const ConsensusParams& consensus,
                  const PlaceRankingParams& params, std::vector<Hypothesis>& hypotheses) {
  DepthConsistencyParams errors = depth;
  errors.absolute_error = params.refined_absolute_error;
  errors.relative_error = params.refined_relative_error;
  const DepthComparison comparison(errors, inverse_depth_std);
  const std::size_t n = std::min<std::size_t>(hypotheses.size(), params.refined_places);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < n; ++i) {
    Hypothesis& h = hypotheses[i];
    if (!h.T_w_c) continue;
    const std::vector<int> models = nearestModels(map, *h.T_w_c, params.evidence_models);
    refine(scene, map, models, inverse_depth_std, params, h);
    h.evidence = evidence(compareWithModels(scene, map, models, *h.T_w_c, comparison), consensus, params);
    least = std::min(least, h.evidence);
  }
  // The others are compared with the larger errors of a pose that is not refined, which is no merit.
  for (std::size_t i = n; i < hypotheses.size(); ++i)
    hypotheses[i].evidence = std::min(hypotheses[i].evidence, least);
  for (Hypothesis& h : hypotheses) h.score = h.consensus + h.evidence;
  mergePlaces(params, hypotheses);
}

void assignProbabilities(const PlaceRankingParams& params, bool with_evidence,
                         std::vector<Hypothesis>& hypotheses) {
  if (hypotheses.empty()) return;
  const double slope = with_evidence ? params.softmax_slope : params.plain_softmax_slope;
  const double null_score = with_evidence ? params.null_score : params.plain_null_score;
  const double largest = std::max(hypotheses.front().score, null_score);  // keeps the exponentials in range
  double sum = std::exp(slope * (null_score - largest));
  for (Hypothesis& h : hypotheses) sum += h.probability = std::exp(slope * (h.score - largest));
  for (Hypothesis& h : hypotheses) h.probability /= sum;
}

}  // namespace facetloc
