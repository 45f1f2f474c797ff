// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/graph_covariance.h"
#include "mapping/keyframe_graph.h"

#include <facetloc/registration/trajectory_links.h>

#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>

namespace facetloc {

using namespace internal;

namespace {

constexpr double kErrorBesideKeyframe = 0.003;  // of an image relative to its keyframe [m, rad]

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

std::vector<Link> trajectoryLinks(const CameraTrajectory& trajectory,
                                  const std::vector<std::size_t>& images) {
  for (const std::size_t image : images)
    if (image >= trajectory.images.size())
      throw std::invalid_argument("links: there is no image " + std::to_string(image));
  const auto partOf = [&](int model) {
    return trajectory.keyframes[trajectory.images[images[model]].keyframe].part;
  };
  std::map<int, std::set<int>> pairs;  // of a model: those after it
  std::map<int, int> latest;           // model of each part
  for (int i = 0; i < static_cast<int>(images.size()); ++i) {
    const auto [before, is_first] = latest.try_emplace(partOf(i), i);
    if (!is_first) pairs[std::exchange(before->second, i)].insert(i);
  }
  const std::vector<int> nearest = nearestModels(trajectory, images);
  for (const KeyframeMotion& m : trajectory.motions) {
    const int a = nearest[m.from], b = nearest[m.to];
    if (a >= 0 && b >= 0 && a != b) pairs[std::min(a, b)].insert(std::max(a, b));
  }

  std::vector<Eigen::Isometry3d> T_w_k;
  for (const Keyframe& k : trajectory.keyframes) T_w_k.push_back(k.T_w_c.T);
  if (T_w_k.empty()) return {};
  const auto& camera = trajectory.keyframes.front().view->camera;
  const GraphCovariance known(keyframeGraph(T_w_k, trajectory.motions,
                                            camera ? camera->mounting : std::nullopt,
                                            MappingParams().odometry.key_distance));
  std::vector<Link> links;
  for (const auto& [a, others] : pairs) {
    const TrajectoryPose& from = trajectory.images[images[a]];
    const auto of_keyframes = known.relativeTo(from.keyframe);
    const Eigen::Isometry3d T_a_key = from.T_w_c.inverse() * T_w_k[from.keyframe];
    for (const int b : others) {
      const TrajectoryPose& to = trajectory.images[images[b]];
      PoseWithCovariance at_keys = *of_keyframes[to.keyframe];
      at_keys.P.diagonal().array() += kErrorBesideKeyframe * kErrorBesideKeyframe;
      PoseWithCovariance T =
          T_a_key * (at_keys * PoseWithCovariance{T_w_k[to.keyframe].inverse() * to.T_w_c, Matrix6d::Zero()});
      links.push_back({a, b, T});
    }
  }
  return links;
}

}  // namespace facetloc
