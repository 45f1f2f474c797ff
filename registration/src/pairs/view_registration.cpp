// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/direction_text.h"
#include "pairs/largest_std.h"

#include <facetloc/registration/cholesky3.h>
#include <facetloc/registration/view_registration.h>

#include <algorithm>
#include <cmath>

namespace facetloc {
namespace {

// Does a pose fix all six degrees of freedom? A refinement that lost pairs leaves the prior's uncertainty.
bool isComplete(const Matrix6d& P, const HypothesisTreeParams& params) {
  return largestStd(P.topLeftCorner<3, 3>()) <= params.complete_rotation_deg * kDegree &&
         largestStd(P.bottomRightCorner<3, 3>()) <= params.complete_translation;
}

// What planes tell of the pose from which they are seen, each measured twice with the same error.
Matrix6d informationOf(const std::vector<Segment>& segments) {
  Matrix6d information = Matrix6d::Zero();
  for (const Segment& s : segments) {
    PlaneMeasurement m;  // of the view against itself
    Cholesky3 noise;
    if (measurePlane(s, s, Eigen::Isometry3d::Identity(), 0.0, m) && noise.compute(m.W))
      information += m.H.transpose() * noise.solve<6>(m.H);
  }
  return information;
}

bool byScore(const Hypothesis& a, const Hypothesis& b) { return a.score > b.score; }

}  // namespace

ViewRegistration::ViewRegistration(const ViewRegistrationParams& params, const SensorNoise& noise,
                                   const Matrix6d& known)
    : params_(params), comparison_(params.depth, noise.inverse_depth_std) {
  if (params.floor_information) known_ = known;
}

bool ViewRegistration::mayFixPose(const View& scene) const {
  // A model without any error would double the information; as much again for what linearisation neglects.
  const Observability most = observability(known_ + 4 * informationOf(scene.segments));
  const double max_rotation = params_.tree.complete_rotation_deg * kDegree,
               max_translation = params_.tree.complete_translation;
  return most.complete(max_rotation, max_translation) ||
         most.oneTranslationFree(max_rotation, max_translation);
}

std::vector<Hypothesis>
ViewRegistration::align(const View& scene, const std::vector<std::vector<Eigen::Vector3d>>& scene_samples,
                        const View& model, const PoseWithCovariance& prior,
                        const PoseWithCovariance& start) const {
  const std::vector<SegmentPair> candidates =
      candidatePairs(scene.segments, model.segments, start, params_.matching);
  const TreeSearchResult found = searchHypotheses(scene.segments, model.segments, candidates, start,
                                                  params_.matching, params_.ekf, params_.tree, known_);

  // Pairs alone tell wrong poses from right ones better than together with what holds for all of them.
  std::vector<Hypothesis> hypotheses;
  for (const FoundPoses* poses : {&found.by_pairs, &found.with_known}) {
    if (hypotheses.empty()) addComplete(scene, model, prior, poses->complete, hypotheses);
  }
  for (const FoundPoses* poses : {&found.by_pairs, &found.with_known}) {
    if (hypotheses.empty() && params_.depth_assistance)
      completeByDepth(scene, model, prior, poses->incomplete, hypotheses);
  }

  for (Hypothesis& h : hypotheses) score(scene, scene_samples, model, kFineColumns, h);
  std::stable_sort(hypotheses.begin(), hypotheses.end(), byScore);
  return hypotheses;
}

std::optional<Hypothesis>
ViewRegistration::alignFrom(const PoseWithCovariance& start, const View& scene,
                            const std::vector<std::vector<Eigen::Vector3d>>& scene_samples,
                            const View& model) const {
  Hypothesis h;
  h.T_m_c = start;
  if (!refineJointly(scene.segments, model.segments, start, params_.matching, {}, h)) return std::nullopt;
  score(scene, scene_samples, model, kCoarseColumns, h);
  return h;
}

// By pixels on a grid of so many columns.
void ViewRegistration::score(const View& scene,
                             const std::vector<std::vector<Eigen::Vector3d>>& scene_samples,
                             const View& model, int columns, Hypothesis& h) const {
  h.consensus =
      params_.consensus.surface_score
          ? surfaceMatchingScore(scene.segments, model.segments, h.T_m_c, params_.matching)
          : logLikelihoodRatio(scene, scene_samples, model, h.T_m_c, comparison_, params_.consensus);
  h.score = h.consensus;
  if (params_.consensus.surface_score || params_.consensus.free_space_weight == 0) return;
  for (const auto& compared : {comparison_.compare(scene.depth, model.depth, h.T_m_c.T, columns),
                               comparison_.compare(model.depth, scene.depth, h.T_m_c.T.inverse(), columns)})
    h.free_space += freeSpaceTerm(compared, params_.consensus);
  h.score += h.free_space;
}

void ViewRegistration::addComplete(const View& scene, const View& model, const PoseWithCovariance& prior,
                                   const std::vector<PoseNode>& complete,
                                   std::vector<Hypothesis>& hypotheses) const {
  for (const PoseNode& node : complete) {
    Hypothesis h;
    h.T_m_c = node.pose;
    h.pairs = node.pairs;
    if (params_.joint_refinement &&
        !refineJointly(scene.segments, model.segments, prior, params_.matching, {}, h))
      continue;
    addDistinct(std::move(h), hypotheses);
  }
}

void ViewRegistration::addDistinct(Hypothesis&& h, std::vector<Hypothesis>& hypotheses) const {
  if (!isComplete(h.T_m_c.P, params_.tree)) return;
  constexpr double kRefinedFactor = 2;  // refined duplicates within 2 deg and 0.1 m are one (METHOD 10.6)
  const bool known = std::any_of(hypotheses.begin(), hypotheses.end(), [&](const Hypothesis& other) {
    return isNear(other.T_m_c.T, h.T_m_c.T, kRefinedFactor * params_.tree.duplicate_translation,
                  kRefinedFactor * params_.tree.duplicate_rotation_deg);
  });
  if (!known) hypotheses.push_back(std::move(h));
}

void ViewRegistration::completeByDepth(const View& scene, const View& model, const PoseWithCovariance& prior,
                                       const std::vector<PoseNode>& incomplete,
                                       std::vector<Hypothesis>& hypotheses) const {
  const int n = std::min<int>(incomplete.size(), params_.max_assisted);
  for (int i = 0; i < n; ++i) {
    const PoseNode& node = incomplete[i];
    const Eigen::Vector3d& v = node.free_direction;
    for (const double position : alignDepth(scene.depth, model.depth, node.pose.T, v,
                                            v.dot(prior.T.translation()), comparison_, params_.alignment)) {
      Hypothesis h;
      h.depth_assisted = true;
      h.pairs = node.pairs;
      h.T_m_c = node.pose;
      h.T_m_c.T.translation() += v * (position - v.dot(node.pose.T.translation()));
      // The position along v is a measurement of its own: fold it into the covariance.
      const double variance = params_.alignment.std * params_.alignment.std;
      const Vector6d Pv = node.pose.P.rightCols<3>() * v;
      h.T_m_c.P -= Pv * Pv.transpose() / (v.dot(Pv.tail<3>()) + variance);
      const TranslationConstraint constraint{v, position, params_.alignment.std};
      if (params_.joint_refinement &&
          !refineJointly(scene.segments, model.segments, prior, params_.matching, constraint, h))
        continue;
      addDistinct(std::move(h), hypotheses);
    }
  }
}

std::string unconstrainedDirections(const std::vector<Segment>& segments, double max_rotation_std_deg,
                                    double max_translation_std, const Matrix6d& known) {
  const Observability seen = observability(known + informationOf(segments));
  std::string text;
  const auto add = [&text](const char* motion, const Eigen::Vector3d& v) {
    text += (text.empty() ? "" : ", ") + std::string(motion) + directionText(v);
  };
  for (int i = 0; i < 3; ++i)
    if (seen.rotation_std[i] > max_rotation_std_deg * kDegree) add("rotation about ", seen.rotations.col(i));
  for (int i = 0; i < 3; ++i)
    if (seen.translation_std[i] > max_translation_std) add("translation along ", seen.directions.col(i));
  return text;
}

}  // namespace facetloc
