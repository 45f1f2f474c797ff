// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/view_registration.h"

#include <facetloc/registration/candidate_pairs.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace facetloc::internal {
namespace {

constexpr int kMostAssisted = 1;  // incomplete poses of a local model that depth may complete

// Limits on the uncertainty of a complete pose, in a view with this noise. No pose is better than the planes
// it comes from: the limits are those for a Kinect, and for noisier cameras larger in proportion
// (METHOD 6.3).
HypothesisTreeParams limitsFor(const View& view, HypothesisTreeParams params) {
  constexpr double kNoisier = 1.3;  // times the specification of a Kinect, whose images have up to 1.25 times
  const double factor = view.noise() / SensorNoise().inverse_depth_std;
  if (factor < kNoisier) return params;
  params.complete_rotation_deg *= factor;
  params.complete_translation *= factor;
  return params;
}

// Does a pose fix all six degrees of freedom? A refinement that lost pairs leaves the prior's uncertainty.
bool isComplete(const Matrix6d& P, const HypothesisTreeParams& params) {
  return largestRotationStd(P) <= params.complete_rotation_deg * kDegree &&
         largestTranslationStd(P) <= params.complete_translation;
}

}  // namespace

std::vector<double> alignDepth(const DepthPicture& scene, const DepthPicture& model,
                               const Eigen::Isometry3d& T_m_c, const Eigen::Vector3d& direction,
                               double centre, const DepthComparison& comparison,
                               const DepthAlignmentParams& params) {
  if (scene.empty() || model.empty()) return {};
  const auto at = [&](double position) {
    Eigen::Isometry3d T = T_m_c;
    T.translation() += direction * (position - direction.dot(T_m_c.translation()));
    return T;
  };
  const int half = std::max(1, static_cast<int>(std::lround(params.range / params.step)));
  // The share of agreeing pixels among the shared ones is the evidence. Their number is none: it depends on
  // the position, and would place a view of a bare corridor where the overlap is largest.
  std::vector<DepthAgreement> found;
  int largest = 0;
  for (int i = -half; i <= half; ++i) {
    const Eigen::Isometry3d T = at(centre + i * params.step);
    found.push_back(comparison.count(scene, model, T, kCoarseColumns));
    found.back() += comparison.count(model, scene, T.inverse(), kCoarseColumns);
    largest = std::max(largest, found.back().judged());
  }
  constexpr double kEnoughShared = 0.25;  // share of the largest overlap; fewer pixels agree by chance
  std::vector<double> agreement;
  for (const DepthAgreement& a : found) {
    const double shared = std::max<double>(a.judged(), kEnoughShared * largest);
    agreement.push_back(largest > 0 ? largest * a.net() / shared : 0);
  }
  const double best = *std::max_element(agreement.begin(), agreement.end());
  const double mean = std::accumulate(agreement.begin(), agreement.end(), 0.0) / agreement.size();
  if (best - mean < params.prominence) return {};

  std::vector<int> maxima;
  for (int i = 1; i + 1 < static_cast<int>(agreement.size()); ++i)
    if (agreement[i] >= agreement[i - 1] && agreement[i] > agreement[i + 1] &&
        agreement[i] >= best - params.runner_up)
      maxima.push_back(i);
  std::stable_sort(maxima.begin(), maxima.end(), [&](int a, int b) { return agreement[a] > agreement[b]; });
  if (maxima.size() > 2) maxima.resize(2);

  const auto likeliest = [&](double around, double step, int steps_aside) {
    struct Step {
      double position;
      DepthAgreement agreement;
    };
    std::vector<Step> tried;
    int most_shared = 1;
    for (int j = -steps_aside; j <= steps_aside; ++j) {
      const double position = around + j * step;
      tried.push_back({position, comparison.compareBoth(scene, model, at(position), kFineColumns)});
      most_shared = std::max(most_shared, tried.back().agreement.judged());
    }
    double best_position = around, best_likelihood = -std::numeric_limits<double>::infinity();
    for (const auto& [position, a] : tried) {
      if (a.judged() < kEnoughShared * most_shared) continue;
      const double likelihood = a.likelihood / a.judged();
      if (likelihood > best_likelihood) best_likelihood = likelihood, best_position = position;
    }
    return best_position;
  };
  constexpr int kSteps = 2;     // to each side of a maximum, then one of half the size
  constexpr double kReach = 2;  // so far [coarse steps]: on the coarse grid the maximum may be a neighbour's
  const double step = kReach * params.step / (kSteps + 0.5);
  std::vector<double> positions;
  for (const int i : maxima) {
    const double near = likeliest(centre + (i - half) * params.step, step, kSteps);
    positions.push_back(likeliest(near, step / 2, 1));
  }
  return positions;
}

ViewRegistration::ViewRegistration(const ViewRegistrationParams& params)
    : params_(params), comparison_(params.calibration.depth), score_(params, comparison_) {}

bool ViewRegistration::mayFixPose(const Query& query) const {
  // A model without any error would double the information; as much again for the neglected terms of
  // linearisation.
  const PrincipalStd most = observability(query.known + 4 * informationOf(query.view.segments));
  const HypothesisTreeParams limits = limitsFor(query.view, params_.tree);
  const double max_rotation = limits.complete_rotation_deg * kDegree,
               max_translation = limits.complete_translation;
  return most.within(max_rotation, max_translation) || most.oneTranslationFree(max_rotation, max_translation);
}

TreeSearchResult ViewRegistration::search(const Query& query, const View& model,
                                          const PoseWithCovariance& start, Chosen chosen,
                                          bool extents) const {
  const std::vector<Segment>&scene = query.view.segments, &of_model = model.segments;
  return searchHypotheses(
      scene, of_model, chosen ? *chosen : candidatePairs(scene, of_model, start, params_.matching), start,
      params_.matching, params_.ekf, limitsFor(query.view, params_.tree), query.known, extents);
}

std::vector<Hypothesis> ViewRegistration::scored(const Query& query, const View& model,
                                                 std::vector<Hypothesis> hypotheses) const {
  for (Hypothesis& h : hypotheses) score_.score(query, model, kFineColumns, h);
  sortByScore(hypotheses);
  return hypotheses;
}

std::vector<Hypothesis> ViewRegistration::align(const Query& query, const View& model,
                                                const PoseWithCovariance& start, Chosen chosen) const {
  const TreeSearchResult found = search(query, model, start, chosen, false);

  // Pairs alone discriminate wrong poses better than together with prior information that holds for all of
  // them.
  std::vector<Hypothesis> hypotheses;
  for (const FoundPoses* poses : {&found.by_pairs, &found.with_known}) {
    if (hypotheses.empty()) addComplete(query, model, poses->complete, chosen, false, hypotheses);
  }
  for (const FoundPoses* poses : {&found.by_pairs, &found.with_known}) {
    if (hypotheses.empty() && params_.steps.depth_assistance)
      completeByDepth(query, model, poses->incomplete, chosen, hypotheses);
  }

  return scored(query, model, std::move(hypotheses));
}

std::vector<Hypothesis> ViewRegistration::alignByExtents(const Query& query, const View& model,
                                                         const PoseWithCovariance& start,
                                                         Chosen chosen) const {
  std::vector<Hypothesis> hypotheses;
  addComplete(query, model, search(query, model, start, chosen, true).by_extents, chosen, true, hypotheses);
  return scored(query, model, std::move(hypotheses));
}

std::optional<Hypothesis> ViewRegistration::alignFrom(const PoseWithCovariance& start, const Query& query,
                                                      const View& model, Chosen chosen) const {
  Hypothesis h;
  h.T_m_c = start;
  if (!refineJointly(query.view.segments, model.segments, start, params_.matching, {}, h, chosen))
    return std::nullopt;
  score_.score(query, model, kCoarseColumns, h);
  return h;
}

void ViewRegistration::addComplete(const Query& query, const View& model,
                                   const std::vector<PoseNode>& complete, Chosen chosen, bool extents,
                                   std::vector<Hypothesis>& hypotheses) const {
  for (const PoseNode& node : complete) {
    Hypothesis h;
    h.T_m_c = node.pose;
    h.pairs = node.pairs;
    addRefined(query, model, {}, chosen, extents, std::move(h), hypotheses);
  }
}

// Unless it is lost on the way, or known.
void ViewRegistration::addRefined(const Query& query, const View& model,
                                  const std::optional<TranslationConstraint>& constraint, Chosen chosen,
                                  bool extents, Hypothesis&& h, std::vector<Hypothesis>& hypotheses) const {
  if (params_.steps.joint_refinement && !refineJointly(query.view.segments, model.segments, query.prior,
                                                       params_.matching, constraint, h, chosen, extents))
    return;
  if (!isComplete(h.T_m_c.P, limitsFor(query.view, params_.tree))) return;
  constexpr double kRefinedFactor = 2;  // refined duplicates within 2 deg and 0.1 m are one (METHOD 6.5)
  const bool known = std::any_of(hypotheses.begin(), hypotheses.end(), [&](const Hypothesis& other) {
    return isNear(other.T_m_c.T, h.T_m_c.T, kRefinedFactor * params_.tree.duplicate_translation,
                  kRefinedFactor * params_.tree.duplicate_rotation_deg);
  });
  if (!known) hypotheses.push_back(std::move(h));
}

void ViewRegistration::completeByDepth(const Query& query, const View& model,
                                       const std::vector<PoseNode>& incomplete, Chosen chosen,
                                       std::vector<Hypothesis>& hypotheses) const {
  const DepthAlignmentParams alignment;
  const int n = std::min(kMostAssisted, static_cast<int>(incomplete.size()));
  for (int i = 0; i < n; ++i) {
    const PoseNode& node = incomplete[i];
    const Eigen::Vector3d& v = node.free_direction;
    for (const double position : alignDepth(query.view.depth, model.depth, node.pose.T, v,
                                            v.dot(query.prior.T.translation()), comparison_, alignment)) {
      Hypothesis h;
      h.depth_assisted = true;
      h.pairs = node.pairs;
      h.T_m_c = node.pose;
      h.T_m_c.T.translation() += v * (position - v.dot(node.pose.T.translation()));
      // The position along v is a measurement of its own: fold it into the covariance.
      const double variance = alignment.std * alignment.std;
      const Vector6d Pv = node.pose.P.rightCols<3>() * v;
      h.T_m_c.P -= Pv * Pv.transpose() / (v.dot(Pv.tail<3>()) + variance);
      addRefined(query, model, TranslationConstraint{v, position, alignment.std}, chosen, false, std::move(h),
                 hypotheses);
    }
  }
}

std::string unconstrainedDirections(const Query& query, const HypothesisTreeParams& params) {
  const HypothesisTreeParams limits = limitsFor(query.view, params);
  return freeMotions(observability(query.known + informationOf(query.view.segments)),
                     limits.complete_rotation_deg * kDegree, limits.complete_translation);
}

std::string whyNoHypothesis(const Query& query, const HypothesisTreeParams& params) {
  if (query.view.segments.empty()) return "the view shows no planar segment";
  const std::string open = unconstrainedDirections(query, params);
  return open.empty() ? "no local model agrees with the view" : "the planes in view leave free: " + open;
}

}  // namespace facetloc::internal
