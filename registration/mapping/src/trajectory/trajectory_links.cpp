// SPDX-License-Identifier: BSD-3-Clause
#include "trajectory/trajectory_links.h"

#include "graph/graph_covariance.h"
#include "trajectory/keyframe_graph.h"

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
      const int of_candidate = trajectory.images[*candidate].keyframe;
      if (trajectory.keyframes[of_candidate].part != keyframe.part) continue;
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

std::vector<Link> internal::trajectoryLinks(const CameraTrajectory& trajectory,
                                            const std::vector<std::size_t>& images) {
  for (const std::size_t image : images)
    if (image >= trajectory.images.size())
      throw std::invalid_argument(fmt::format("links: there is no image {}", image));
  const auto partOf = [&](int model) {
    return trajectory.keyframes[trajectory.images[images[model]].keyframe].part;
  };
  std::set<std::pair<int, int>> pairs;
  std::map<int, int> latest;  // model of each part
  for (int i = 0; i < static_cast<int>(images.size()); ++i) {
    const auto [before, is_first] = latest.try_emplace(partOf(i), i);
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
