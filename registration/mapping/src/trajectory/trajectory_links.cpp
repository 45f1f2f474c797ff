// SPDX-License-Identifier: BSD-3-Clause
#include "trajectory/trajectory_links.h"

#include "graph/graph_covariance.h"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <optional>
#include <stdexcept>
#include <utility>

namespace facetloc {

using namespace internal;

namespace {

constexpr double kErrorBesideKeyframe = 0.003;  // error of an image relative to its keyframe [m, rad]

/** Index of the local model that is nearest in the order of images to each keyframe, of the same part. */
std::vector<int> nearestModels(const CameraTrajectory& trajectory, const std::vector<std::size_t>& images) {
  std::vector<int> nearest(trajectory.keyframes.size(), -1);
  for (std::size_t k = 0; k < nearest.size(); ++k) {
    const Keyframe& keyframe = trajectory.keyframes[k];
    const auto after = std::lower_bound(images.begin(), images.end(), keyframe.image);
    std::size_t least = 0;
    for (const auto candidate : {after, after == images.begin() ? images.end() : after - 1}) {
      if (candidate == images.end()) continue;
      if (trajectory.partOf(trajectory.images[*candidate]) != keyframe.part) continue;
      const std::size_t distance =
          *candidate > keyframe.image ? *candidate - keyframe.image : keyframe.image - *candidate;
      if (nearest[k] >= 0 && distance >= least) continue;
      least = distance;
      nearest[k] = static_cast<int>(candidate - images.begin());
    }
  }
  return nearest;
}

}  // namespace

PoseGraph internal::keyframeGraph(const std::vector<Eigen::Isometry3d>& T_w_k,
                                  const std::vector<KeyframeMotion>& motions,
                                  const std::optional<CameraMounting>& mounting, double key_distance) {
  constexpr double kFloorLength = 0.7;  // distance after which a robot stands on other unevenness [m]
  const auto isComparison = [](const KeyframeMotion& m) {
    return m.source != KeyframeMotion::Source::odometry;
  };
  std::vector<int> comparisons(T_w_k.size(), 0);
  for (const KeyframeMotion& m : motions)
    if (isComparison(m)) ++comparisons[m.from], ++comparisons[m.to];
  PoseGraph graph;
  graph.T_w_n = T_w_k;
  for (const KeyframeMotion& m : motions) {
    PoseEdge edge{m.from, m.to, m.T_from_to, isComparison(m)};
    edge.others = m.others;
    if (isComparison(m)) {
      const double shared = std::max(1.0, (comparisons[m.from] + comparisons[m.to]) / 4.0);
      edge.T_from_to.P *= shared;
      for (AlternativeMotion& other : edge.others) other.T_from_to.P *= shared;
    }
    graph.edges.push_back(edge);
  }
  if (mounting) {
    const double repeated = std::max(1.0, kFloorLength / key_distance);
    graph.floor = LevelFloor{mounting->T_b_c(), repeated * floorCovariance({})};
  }
  return graph;
}

PoseGraph internal::keyframeGraph(const CameraTrajectory& trajectory,
                                  const std::optional<CameraMounting>& mounting) {
  std::vector<Eigen::Isometry3d> T_w_k;
  for (const Keyframe& k : trajectory.keyframes) T_w_k.push_back(k.T_w_c.T);
  return keyframeGraph(T_w_k, trajectory.motions, mounting, MappingParams().odometry.key_distance);
}

std::vector<Link> internal::trajectoryLinks(const CameraTrajectory& trajectory,
                                            const std::vector<std::size_t>& images) {
  for (const std::size_t image : images)
    if (image >= trajectory.images.size())
      throw std::invalid_argument(fmt::format("links: there is no image {}", image));
  std::set<std::pair<int, int>> pairs;
  std::map<int, int> latest;  // model of each part
  for (int i = 0; i < static_cast<int>(images.size()); ++i) {
    const auto [before, is_first] = latest.try_emplace(trajectory.partOf(trajectory.images[images[i]]), i);
    if (!is_first) pairs.emplace(std::exchange(before->second, i), i);
  }
  const std::vector<int> nearest = nearestModels(trajectory, images);
  for (const KeyframeMotion& m : trajectory.motions) {
    const int a = nearest[m.from], b = nearest[m.to];
    if (a >= 0 && b >= 0 && a != b) pairs.insert(std::minmax(a, b));
  }

  std::vector<PlaceOnTrajectory> places;
  for (const std::size_t image : images) {
    const TrajectoryPose& pose = trajectory.images[image];
    places.push_back({pose.keyframe, trajectory.keyframes[pose.keyframe].T_w_c.T.inverse() * pose.T_w_c});
  }
  return linksBetween(trajectory, places, pairs);
}

std::vector<Link> internal::linksBetween(const CameraTrajectory& trajectory,
                                         const std::vector<PlaceOnTrajectory>& places,
                                         const std::set<std::pair<int, int>>& pairs) {
  if (pairs.empty()) return {};
  const auto& camera = trajectory.keyframes.front().view->camera;
  const GraphCovariance known(keyframeGraph(trajectory, camera ? camera->mounting : std::nullopt));
  std::vector<Link> links;
  for (const auto& [a, b] : pairs) {
    const PlaceOnTrajectory &from = places[a], &to = places[b];
    std::optional<PoseWithCovariance> T_key_key = known.between(from.keyframe, to.keyframe);
    if (!T_key_key) continue;
    T_key_key->P.diagonal().array() += kErrorBesideKeyframe * kErrorBesideKeyframe;
    links.push_back(
        {a, b, from.T_k_c.inverse() * (*T_key_key * PoseWithCovariance{to.T_k_c, Matrix6d::Zero()})});
  }
  return links;
}

}  // namespace facetloc
