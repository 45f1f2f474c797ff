// SPDX-License-Identifier: BSD-3-Clause
#include "trajectory/trajectory_graph.h"

#include "motion/step_prior.h"
#include "poses/pose_fusion.h"
#include "trajectory/trajectory_links.h"

#include <cmath>
#include <stdexcept>
#include <utility>

namespace facetloc::internal {

using Source = KeyframeMotion::Source;

std::vector<KeyframeMotion> TrajectoryGraph::motions() const {
  std::vector<KeyframeMotion> all;
  for (int k = 0; k < size(); ++k)
    if (const RelativePosition& at = nodes_[k].at; at.known)
      all.push_back(
          {nodes_[k].before, k, {at.by_motion.T, withSharedErrors(at.by_motion.P)}, Source::odometry});
  for (const KeyframeMotion& m : relations_) {
    all.push_back(m);
    if (m.from == nodes_[m.to].before) all.back().others = nodes_[m.to].at.others;
  }
  return all;
}

std::optional<CameraMounting> TrajectoryGraph::mounting() const {
  if (nodes_.empty() || !nodes_.front().view->camera) return {};
  return nodes_.front().view->camera->mounting;
}

// Has a robot been seen to move sideways more often than errors explain?
bool TrajectoryGraph::slides(const CameraMounting& mounting) const {
  constexpr double kSure = 3, kOften = 0.1;
  constexpr int kFewest = 10;  // steps
  int seen = 0, sideways = 0;
  for (const KeyframeMotion& step : relations_) {
    if (step.to != step.from + 1) continue;
    const SidewaysShift s = sidewaysShift(step.T_from_to, mounting);
    if (s.variance > kSidewaysStd * kSidewaysStd) continue;
    ++seen;
    sideways += std::abs(s.shift) > kSure * std::sqrt(s.variance + kSidewaysStd * kSidewaysStd);
  }
  return seen >= kFewest && sideways > kOften * seen;
}

PoseWithCovariance TrajectoryGraph::guessedStep() const {
  const auto m = mounting();
  return {Eigen::Isometry3d::Identity(), stepCovariance(m, !m || slides(*m))};
}

PoseGraph TrajectoryGraph::poseGraph() const {
  std::vector<Eigen::Isometry3d> T;
  for (const TrajectoryNode& node : nodes_) T.push_back(node.T_w_c.T);
  return keyframeGraph(T, motions(), mounting(), params_.key_distance);
}

void TrajectoryGraph::add(TrajectoryNode node) {
  node.piece = node.part = size();
  if (node.at.known) {
    node.piece = nodes_[node.before].piece;
    follow(node);
    if (node.at.placed)
      relations_.push_back({node.before, size(), measured(*node.at.placed), Source::overlap});
  } else if (node.view->camera && node.view->camera->mounting) {
    node.T_w_c.T = node.view->camera->mounting->T_b_c();
  }
  nodes_.push_back(std::move(node));
}

// Moves a keyframe rigidly with the one before.
void TrajectoryGraph::follow(TrajectoryNode& node) const {
  const TrajectoryNode& before = nodes_[node.before];
  node.T_w_c = before.T_w_c * PoseWithCovariance{node.at.T, withSharedErrors(node.at.by_motion.P)};
  node.part = before.part;
}

void TrajectoryGraph::keepRelations(int first, std::vector<KeyframeMotion>& found) const {
  for (const KeyframeMotion& m : relations_)
    if (m.to < first || ((m.source == Source::loop || m.from == nodes_[m.to].before) &&
                         std::none_of(found.begin(), found.end(), [&](const KeyframeMotion& f) {
                           return f.from == m.from && f.to == m.to;
                         })))
      found.push_back(m);
}

// Moves parts that have been tied to where their first ties place them, close to the solution.
void TrajectoryGraph::alignParts() {
  for (const KeyframeMotion& m : motions()) {
    const bool forward = nodes_[m.from].part < nodes_[m.to].part;  // the later part moves
    const TrajectoryNode &a = nodes_[forward ? m.from : m.to], &b = nodes_[forward ? m.to : m.from];
    const int kept = a.part, moved = b.part;
    if (kept == moved) continue;
    const Eigen::Isometry3d T_a_b = forward ? m.T_from_to.T : m.T_from_to.T.inverse();
    const Eigen::Isometry3d T_kept_moved = a.T_w_c.T * T_a_b * b.T_w_c.T.inverse();
    for (TrajectoryNode& node : nodes_)
      if (node.part == moved) {
        node.T_w_c.T = T_kept_moved * node.T_w_c.T;
        node.part = kept;
      }
  }
}

double TrajectoryGraph::optimize(std::vector<KeyframeMotion> found) {
  std::vector<Eigen::Isometry3d> before;
  for (const TrajectoryNode& node : nodes_) before.push_back(node.T_w_c.T);
  relations_ = std::move(found);
  for (const bool last : {false, true}) {
    alignParts();
    const GraphPoses poses = optimized(poseGraph(), last);
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      nodes_[k].T_w_c = poses.nodes[k];
      nodes_[k].part = poses.part[k];
    }
    if (last) break;
    const std::vector<double>& mismatch = poses.mismatch;
    auto of_relation = mismatch.end() - static_cast<std::ptrdiff_t>(relations_.size());
    std::vector<KeyframeMotion> kept;
    for (const KeyframeMotion& m : relations_)
      if (!(*of_relation++ > kFarEllipsoid) &&
          (m.source != Source::loop ||
           depthAgrees(between(m.from, m.to), *(*this)[m.from].view, *(*this)[m.to].view)))
        kept.push_back(m);
    relations_ = std::move(kept);
  }
  double moved = 0;
  for (std::size_t k = 0; k < nodes_.size(); ++k)
    moved = std::max(moved, (before[k].translation() - nodes_[k].T_w_c.T.translation()).norm());
  return moved;
}

void TrajectoryGraph::adopt(const TrajectoryGraph& improved) {
  const int n = improved.size();
  if (n > size())
    throw std::invalid_argument("TrajectoryEstimation: only a clone of this trajectory can be adopted");
  std::vector<KeyframeMotion> all = improved.relations_;
  std::copy_if(relations_.begin(), relations_.end(), std::back_inserter(all),
               [n](const KeyframeMotion& m) { return m.to >= n; });
  relations_ = std::move(all);
  for (int k = 0; k < size(); ++k) {
    if (k < n) {
      nodes_[k].T_w_c = improved[k].T_w_c;
      nodes_[k].part = improved[k].part;
    } else if (nodes_[k].at.known) {
      follow(nodes_[k]);
    }
  }
}

}  // namespace facetloc::internal
