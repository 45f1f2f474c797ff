// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/consensus.h"

#include "pairs/cholesky3.h"
#include "pairs/plane_measurement.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace facetloc::internal {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kMinSceneCosine = 0.7;            // normals further apart explain nothing
constexpr double kParallelSpread = 3 * kDegree;    // width of a direction already seen (METHOD 10.2)
constexpr double kCoplanarSpread = 1.5 * kDegree;  // spread of the direction of another part of a plane ...
constexpr double kCoplanarOffset = 0.03;           // ... and of its offset [m]
constexpr double kHullMargin = 0.05;  // slack of outlines [m], besides twice the position's uncertainty
constexpr double kMinVisible = 0.05;  // share of visible samples below which a segment says nothing
constexpr double kMinLlr = -10, kMaxLlr = 15;  // bounds of a pair's log likelihood ratio (METHOD 10.1)

// Log likelihood of a pair under the hypothesis, with slack (METHOD 10.1).
double pairLogLikelihood(const PlaneMeasurement& m, const Matrix6d& P, const ScoreCalibration& params) {
  Eigen::Matrix3d S = m.H * P * m.H.transpose() + m.W;
  const double slope = std::pow(params.slope_slack_deg * kDegree, 2);
  S.diagonal() += Eigen::Vector3d(slope, slope, params.offset_slack * params.offset_slack);
  Cholesky3 cholesky;
  if (!cholesky.compute(S)) return -std::numeric_limits<double>::infinity();
  return -0.5 * (cholesky.squaredMahalanobis(m.h) + 3 * std::log(2 * kPi) + cholesky.logDeterminant());
}

// Density of a plane that is another part of one that an earlier, shown segment of the scene shows already,
// where segment j lies.
double coplanarDensity(const std::vector<Segment>& scene, const std::vector<std::size_t>& shown,
                       std::size_t j) {
  static const double least_cosine = std::cos(4 * kCoplanarSpread);
  double most = 0;
  for (const std::size_t i : shown) {
    const double cosine = scene[i].normal().dot(scene[j].normal());
    if (cosine < least_cosine) continue;
    const double angle = std::acos(std::min(1.0, cosine)) / kCoplanarSpread;
    const double offset = scene[i].normal().dot(scene[j].t - scene[i].t) / kCoplanarOffset;
    most = std::max(most, std::exp(-0.5 * (angle * angle + offset * offset)));
  }
  return most / (std::pow(2 * kPi, 1.5) * kCoplanarSpread * kCoplanarSpread * kCoplanarOffset);
}

// Density of a chance plane with normal u, given the directions that the scene has shown already and the
// density that it is part of a plane that it has shown (METHOD 10.2). If a noisy camera splits a wall into
// pieces, each further one is nearly certain by chance, however well it fits.
double chanceDensity(const Eigen::Vector3d& u, const std::vector<Eigen::Vector3d>& seen, double coplanar,
                     const ScoreCalibration& params) {
  const double uniform = 1 / (2 * kPi);
  if (seen.empty()) return uniform / params.max_offset;
  double parallel = 0;
  for (const Eigen::Vector3d& d : seen) {
    const double angle = std::acos(std::clamp(u.dot(d), -1.0, 1.0));
    parallel = std::max(parallel, std::exp(-0.5 * std::pow(angle / kParallelSpread, 2)));
  }
  parallel /= 2 * kPi * kParallelSpread * kParallelSpread;
  const double elsewhere = params.parallel_weight * (1 - params.coplanar_weight);
  return ((1 - params.parallel_weight) * uniform + elsewhere * parallel) / params.max_offset +
         params.parallel_weight * params.coplanar_weight * coplanar;
}

// Is a point, given in the frame of a picture's camera, in view and not behind something that it shows?
bool visible(const Eigen::Vector3d& p, const DepthPicture& picture, const DepthErrors& errors) {
  constexpr double kNearest = 0.4, kFarthest = 7.5;  // range in which planes are used [m]
  if (picture.empty()) return true;
  if (p.z() < kNearest || p.z() > kFarthest) return false;
  const Eigen::Vector2d pixel = picture.camera.project(p);
  const int u = static_cast<int>(std::lround(pixel.x())), v = static_cast<int>(std::lround(pixel.y()));
  if (u < 0 || v < 0 || u >= picture.camera.width || v >= picture.camera.height) return false;
  const std::size_t i = static_cast<std::size_t>(v) * picture.camera.width + u;
  if (picture.inverse_depth[i] == 0) return false;
  return 1 / p.z() >= picture.inverse_depth[i] * DepthPicture::kQuantum - errors.tolerance(1 / p.z());
}

// Poses of the model's frame in the cameras of its side pictures.
std::vector<Eigen::Isometry3d> sidePoses(const View& model) {
  std::vector<Eigen::Isometry3d> T_c_m;
  for (const SidePicture& side : model.sides) T_c_m.push_back(side.T_v_c.inverse());
  return T_c_m;
}

// Does any picture of the model show a point in the model's frame?
bool visible(const Eigen::Vector3d& p, const View& model, const std::vector<Eigen::Isometry3d>& side_poses,
             const DepthErrors& errors) {
  if (visible(p, model.depth, errors)) return true;
  for (std::size_t k = 0; k < side_poses.size(); ++k)
    if (visible(side_poses[k] * p, *model.sides[k].picture, errors)) return true;
  return false;
}

struct Explanation {
  const Segment* model;
  double llr;
};

// Evidence of contradicting pixels against a pose: -w ln(1 + c / c_0) [nats], where c is their share among
// those compared. The term is not linear in c, since pixels do not contradict one by one: a moved object
// covers a whole region. The share of changed pixels in a true view is mostly tiny and now and then large,
// with a tail like a power of c; so is the evidence against the pose.
double freeSpaceTerm(const DepthAgreement& compared, const ScoreCalibration& params) {
  const double share = compared.contradict / std::max(1.0, double(compared.judged()));
  return -params.free_space_weight * std::log1p(share / params.free_space_share);
}

}  // namespace

std::vector<Eigen::Vector3d> samplePoints(const Segment& s) {
  constexpr double kSamples = 24;  // approximate number, at least a few
  std::vector<Eigen::Vector3d> points;
  if (s.hull.size < 3) return points;
  Eigen::Vector2f low = s.hull.vertex[0], high = low;
  for (const Eigen::Vector2f& v : s.hull) low = low.cwiseMin(v), high = high.cwiseMax(v);
  const float spacing = std::sqrt(std::max(1e-6f, s.hull.area()) / static_cast<float>(kSamples));
  const Eigen::Vector2f extent = high - low;
  constexpr float kMost = 256;  // samples along one side, for slivers
  const int columns = static_cast<int>(std::min(kMost, extent.x() / spacing + 0.5f));
  const int rows = static_cast<int>(std::min(kMost, extent.y() / spacing + 0.5f));
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const Eigen::Vector2f p = low + spacing * Eigen::Vector2f(i + 0.5f, j + 0.5f);
      if (s.hull.contains(p)) points.push_back(s.t + p.x() * s.R.col(0) + p.y() * s.R.col(1));
    }
  if (points.empty()) points.push_back(s.t);
  return points;
}

Query::Query(const View& scene, const PoseWithCovariance& prior_pose, const Matrix6d& known_information)
    : view(scene), prior(prior_pose), known(known_information) {
  samples.reserve(view.segments.size());
  for (const Segment& s : view.segments) samples.push_back(samplePoints(s));
}

double logLikelihoodRatio(const Query& query, const View& model, const PoseWithCovariance& T_m_c,
                          const DepthComparison& comparison, const ScoreCalibration& params) {
  const View& scene = query.view;
  const DepthErrors errors = comparison.errorsBetween(scene.depth, model.depth);
  const std::vector<Eigen::Isometry3d> side_poses = sidePoses(model);
  // The largest over all directions, not over the axes of the model: the score does not depend on those.
  const auto margin = static_cast<float>(kHullMargin + 2 * largestTranslationStd(T_m_c.P));
  // No pair is likelier than an exact one whose uncertainty is the slack alone.
  const double highest = -0.5 * 3 * std::log(2 * kPi) -
                         std::log(std::pow(params.slope_slack_deg * kDegree, 2) * params.offset_slack);
  double sum = 0;
  std::vector<Eigen::Vector3d> seen;
  std::vector<std::size_t> shown;
  std::vector<Explanation> explanations;
  std::vector<int> covered;
  for (std::size_t j = 0; j < scene.segments.size(); ++j) {
    const Segment& F = scene.segments[j];
    const Eigen::Vector3d u = T_m_c.T.linear() * F.normal();
    const double coplanar = params.coplanar_weight > 0 ? coplanarDensity(scene.segments, shown, j) : 0;
    const double log_chance = std::log(chanceDensity(u, seen, coplanar, params));
    explanations.clear();
    for (const Segment& Fp : model.segments) {
      if (!(u.dot(Fp.normal()) > kMinSceneCosine)) continue;
      if (highest - 0.5 * offsetDistance(F, Fp, T_m_c, params.offset_slack) - log_chance < kMinLlr) continue;
      PlaneMeasurement m;
      if (!measurePlane(F, Fp, T_m_c.T, kMinSceneCosine, m)) continue;
      const double llr = pairLogLikelihood(m, T_m_c.P, params) - log_chance;
      if (llr > kMinLlr) explanations.push_back({&Fp, std::min(llr, kMaxLlr)});
    }
    std::sort(explanations.begin(), explanations.end(),
              [](const Explanation& a, const Explanation& b) { return a.llr > b.llr; });

    int num_visible = 0;
    covered.assign(explanations.size(), 0);
    for (const Eigen::Vector3d& sample : query.samples[j]) {
      const Eigen::Vector3d p = T_m_c.T * sample;
      if (!visible(p, model, side_poses, errors)) continue;
      ++num_visible;
      for (std::size_t i = 0; i < explanations.size(); ++i) {
        const Segment& Fp = *explanations[i].model;
        const Eigen::Vector3d in_plane = Fp.R.transpose() * (p - Fp.t);
        if (!Fp.hull.contains(in_plane.head<2>().cast<float>(), margin)) continue;
        ++covered[i];  // each sample counts for the best explanation that covers it
        break;
      }
    }
    const double visible_share = num_visible / static_cast<double>(query.samples[j].size());
    if (visible_share > kMinVisible) {
      double explained = 0;
      for (std::size_t i = 0; i < explanations.size(); ++i)
        explained += covered[i] / static_cast<double>(num_visible) * std::exp(explanations[i].llr);
      sum += visible_share * std::log(1 - params.match_probability + params.match_probability * explained);
    }
    // A surface that another camera sees and the model does not show makes none of its surfaces likelier.
    if (!scene.sides.empty() && !(visible_share > kMinVisible)) continue;
    shown.push_back(j);
    const bool new_direction = std::none_of(seen.begin(), seen.end(), [&u](const Eigen::Vector3d& d) {
      return u.dot(d) > std::cos(kParallelSpread);
    });
    if (new_direction) seen.push_back(u);
  }
  return sum;
}

double surfaceMatchingScore(const std::vector<Segment>& scene, const std::vector<Segment>& model,
                            const PoseWithCovariance& T_m_c, const MatchingParams& matching) {
  const auto upperTail = [](double d2) {  // upper tail of chi2(3)
    return 1 - std::erf(std::sqrt(d2 / 2)) + std::sqrt(2 * d2 / kPi) * std::exp(-d2 / 2);
  };
  double sum = 0;
  for (const Segment& F : scene) {
    double best = 0;
    for (const Segment& Fp : model) {
      const double d2 = coplanarityDistance(F, Fp, T_m_c, matching.coplanarity_gate);
      if (!(d2 <= matching.coplanarity_gate)) continue;
      if (!(overlapDistance(F, Fp, T_m_c, matching.overlap_gate) <= matching.overlap_gate)) continue;
      best = std::max(best, 100 * upperTail(d2) * std::min(F.num_points, Fp.num_points));
    }
    sum += best;
  }
  return sum;
}

void HypothesisScore::score(const Query& query, const View& model, int columns, Hypothesis& h) const {
  if (by_overlap_) {
    h.score = h.consensus = surfaceMatchingScore(query.view.segments, model.segments, h.T_m_c, matching_);
    return;
  }
  h.consensus = logLikelihoodRatio(query, model, h.T_m_c, comparison_, params_);
  h.score = h.consensus;
  if (params_.free_space_weight == 0) return;
  const DepthPicture &scene = query.view.depth, &of_model = model.depth;
  for (const auto& compared : {comparison_.count(scene, of_model, h.T_m_c.T, columns),
                               comparison_.count(of_model, scene, h.T_m_c.T.inverse(), columns)})
    h.free_space += freeSpaceTerm(compared, params_);
  h.score += h.free_space;
}

void sortByScore(std::vector<Hypothesis>& hypotheses) {
  std::stable_sort(hypotheses.begin(), hypotheses.end(),
                   [](const Hypothesis& a, const Hypothesis& b) { return a.score > b.score; });
}

}  // namespace facetloc::internal
