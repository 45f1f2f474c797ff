// SPDX-License-Identifier: BSD-3-Clause
#include "sessions/session_place.h"

#include "graph/consistency_graph.h"
#include "poses/pose_fusion.h"
#include "sessions/parallel_stage.h"
#include "trajectory/trajectory_graph.h"

#include <algorithm>
#include <fmt/format.h>
#include <map>

namespace facetloc {

using namespace internal;

namespace {

// Errors of an answer that its covariance does not know: those of the local model's own pose.
constexpr double kMapRotation = 0.2 * kDegree, kMapTranslation = 0.01;  // [m]

// Standard deviations of a keyframe in the map, beyond which nothing is concluded from it [rad, m].
constexpr double kCertainRotation = 2 * kDegree, kCertainTranslation = 0.1;

/** The sure answers of all keyframes, none of which has a place yet. */
std::vector<FoundKeyframe> sureKeyframes(const GlobalLocalization& localization,
                                         const CameraTrajectory& trajectory, int threads,
                                         const MapProgressCallback& progress, SessionPlace& place) {
  const std::size_t n = trajectory.keyframes.size();
  std::vector<std::optional<PoseWithCovariance>> T_w_c(n);
  ParallelStage(MapProgress::Stage::place, n, threads, progress).run([&](std::size_t k) {
    const Localization answer = localization.localize(*trajectory.keyframes[k].view);
    if (answer.state == AnswerState::sure && answer.hypotheses.front().T_w_c) {
      const Hypothesis& h = answer.hypotheses.front();
      const Eigen::Isometry3d T_w_m = *h.T_w_c * h.T_m_c.T.inverse();
      PoseWithCovariance T = T_w_m * h.T_m_c;
      T.P.diagonal().head<3>().array() += kMapRotation * kMapRotation;
      T.P.diagonal().tail<3>().array() += kMapTranslation * kMapTranslation;
      T_w_c[k] = T;
    }
  });
  std::vector<FoundKeyframe> found;
  for (std::size_t k = 0; k < n; ++k)
    if (T_w_c[k]) found.push_back({static_cast<int>(k), *T_w_c[k]});
  place.asked = n;
  place.sure = found.size();
  place.T_w_k.resize(n);
  place.confirmed.assign(n, false);
  return found;
}

/** The parts of a graph without the edges that its poses contradict. */
std::vector<int> withoutBreaks(PoseGraph graph, const GraphPoses& poses) {
  std::vector<PoseEdge> sound;
  for (std::size_t i = 0; i < graph.edges.size(); ++i)
    if (poses.mismatch[i] <= kFarEllipsoid) sound.push_back(graph.edges[i]);
  graph.edges = std::move(sound);
  return partsOf(graph);
}

bool isCertain(const Matrix6d& P) {
  return largestRotationStd(P) <= kCertainRotation && largestTranslationStd(P) <= kCertainTranslation;
}

template <class Predicate>
std::vector<FoundKeyframe> those(const std::vector<FoundKeyframe>& found, const Predicate& predicate) {
  std::vector<FoundKeyframe> out;
  std::copy_if(found.begin(), found.end(), std::back_inserter(out), predicate);
  return out;
}

/** T_w_s of the set's members, one each, and of these the one that lies in the middle of the others. */
Eigen::Isometry3d middlePlace(const std::vector<FoundKeyframe>& set, const std::vector<Keyframe>& keyframes) {
  std::vector<Eigen::Isometry3d> T_w_s;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const FoundKeyframe& f : set) {
    T_w_s.push_back(f.T_w_c.T * keyframes[f.keyframe].T_w_c.T.inverse());
    centre += keyframes[f.keyframe].T_w_c.T.translation() / double(set.size());
  }
  const auto sumOfDistances = [&](const Eigen::Isometry3d& T) {
    double sum = 0;
    for (const Eigen::Isometry3d& other : T_w_s) sum += (T * centre - other * centre).norm();
    return sum;
  };
  return *std::min_element(T_w_s.begin(), T_w_s.end(), [&](const auto& a, const auto& b) {
    return sumOfDistances(a) < sumOfDistances(b);
  });
}

}  // namespace

std::string SessionPlace::toString() const {
  return fmt::format("{} of {} {} sure, {} of them agree", sure, asked,
                     asked == 1 ? "image is" : "images are", agreeing);
}

SessionPlace internal::placeInMap(const GlobalLocalization& localization, const CameraTrajectory& trajectory,
                                  const MapSessionParams& params, int threads,
                                  const MapProgressCallback& progress) {
  checkRanges(params);
  SessionPlace place;
  const std::vector<FoundKeyframe> found = sureKeyframes(localization, trajectory, threads, progress, place);
  if (found.empty()) return place;

  // Its keyframes alone: the floor of the map is not the floor of the session's world.
  const PoseGraph of_session = keyframeGraph(trajectory, {});
  const GraphCovariance known(of_session, threads);
  std::map<int, std::vector<std::optional<PoseWithCovariance>>> from;
  const RelativePose relative = [&](int a, int b) {
    const auto at = from.find(a);
    return (at != from.end() ? at : from.emplace(a, known.relativeTo(a)).first)->second[b];
  };

  PoseGraph graph;  // node 0 is the map's world
  graph.T_w_n.push_back(Eigen::Isometry3d::Identity());
  graph.T_w_n.insert(graph.T_w_n.end(), of_session.T_w_n.begin(), of_session.T_w_n.end());
  for (PoseEdge edge : of_session.edges) {
    ++edge.from, ++edge.to;
    edge.may_be_wrong = true;  // a trajectory may break anywhere, and the map is there to tell
    graph.edges.push_back(edge);
  }
  const auto least = static_cast<std::size_t>(params.min_agreeing);
  for (const int part : trajectory.parts()) {
    std::vector<FoundKeyframe> left =
        those(found, [&](const FoundKeyframe& f) { return trajectory.keyframes[f.keyframe].part == part; });
    const std::vector<FoundKeyframe> main = consensusAlignment(left, relative, least);
    if (main.empty()) continue;
    place.agreeing += main.size();
    const Eigen::Isometry3d T_w_s = middlePlace(main, trajectory.keyframes);
    for (std::size_t k = 0; k < trajectory.keyframes.size(); ++k)
      if (trajectory.keyframes[k].part == part) graph.T_w_n[k + 1] = T_w_s * graph.T_w_n[k + 1];
    // Stretches beyond a break of the trajectory agree among themselves.
    for (std::vector<FoundKeyframe> set = main; !set.empty();
         set = consensusAlignment(left, relative, least)) {
      for (const FoundKeyframe& f : set) graph.edges.push_back({0, f.keyframe + 1, f.T_w_c, true});
      left = those(left, [&set](const FoundKeyframe& f) {
        return std::none_of(set.begin(), set.end(),
                            [&](const FoundKeyframe& other) { return other.keyframe == f.keyframe; });
      });
    }
  }
  if (!place.found()) return place;
  const GraphPoses poses = optimized(graph);
  const std::vector<int> part = withoutBreaks(graph, poses);
  for (std::size_t k = 0; k < place.T_w_k.size(); ++k)
    if (part[k + 1] == part[0] && isCertain(poses.nodes[k + 1].P)) place.T_w_k[k] = poses.nodes[k + 1].T;
  for (const FoundKeyframe& f : found) {
    auto& T_w_k = place.T_w_k[f.keyframe];
    if (!T_w_k) continue;
    place.confirmed[f.keyframe] = kSameAnswer.joins(*T_w_k, f.T_w_c.T);
    if (!place.confirmed[f.keyframe]) T_w_k.reset();  // it is sure to be elsewhere
  }
  return place;
}

SessionPlace internal::placeRigidly(const GlobalLocalization& localization,
                                    const CameraTrajectory& trajectory, const MapBuilderParams& accuracy,
                                    const MapSessionParams& params, int threads,
                                    const MapProgressCallback& progress) {
  checkRanges(params);
  SessionPlace place;
  const std::vector<FoundKeyframe> found = sureKeyframes(localization, trajectory, threads, progress, place);
  const MapBuilder builder(accuracy);
  const RelativePose relative = [&](int a, int b) {
    return builder.link(a, b, trajectory.keyframes[a].T_w_c.T, trajectory.keyframes[b].T_w_c.T).T_from_to;
  };
  const std::vector<FoundKeyframe> set =
      consensusAlignment(found, relative, static_cast<std::size_t>(params.min_agreeing));
  if (set.empty()) return place;
  place.agreeing = set.size();
  place.confirmed.assign(trajectory.keyframes.size(), true);

  // Two nodes, the world and the session: each answer is a measurement of the motion between them.
  const Eigen::Isometry3d start = middlePlace(set, trajectory.keyframes);
  PoseGraph graph;
  graph.T_w_n = {Eigen::Isometry3d::Identity(), start};
  for (const FoundKeyframe& f : set)
    graph.edges.push_back({0, 1, f.T_w_c * inverse(trajectory.keyframes[f.keyframe].T_w_c), true});
  const Eigen::Isometry3d T_w_s = optimized(graph, false).nodes[1].T;
  const bool stays =
      std::all_of(trajectory.keyframes.begin(), trajectory.keyframes.end(),
                  [&](const Keyframe& k) { return kSameAnswer.joins(T_w_s * k.T_w_c.T, k.T_w_c.T); });
  for (std::size_t k = 0; k < place.T_w_k.size(); ++k)
    place.T_w_k[k] = stays ? trajectory.keyframes[k].T_w_c.T : T_w_s * trajectory.keyframes[k].T_w_c.T;
  return place;
}

}  // namespace facetloc
