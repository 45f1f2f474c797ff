// SPDX-License-Identifier: BSD-3-Clause
#include "trajectory/keyframe_graph.h"

#include <facetloc/registration/pose_prior.h>

#include <algorithm>

namespace facetloc::internal {

PoseGraph keyframeGraph(const std::vector<Eigen::Isometry3d>& T_w_k,
                        const std::vector<KeyframeMotion>& motions,
                        const std::optional<CameraMounting>& mounting, double key_distance) {
  constexpr double kFloorLength = 0.7;  // way after which a robot stands on other unevenness [m]
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
    if (isComparison(m)) edge.T_from_to.P *= std::max(1.0, (comparisons[m.from] + comparisons[m.to]) / 4.0);
    graph.edges.push_back(edge);
  }
  if (mounting) {
    const double repeated = std::max(1.0, kFloorLength / key_distance);
    graph.floor = LevelFloor{mounting->T_b_c(), repeated * floorCovariance({})};
  }
  return graph;
}

PoseGraph keyframeGraph(const CameraTrajectory& trajectory, const std::optional<CameraMounting>& mounting) {
  std::vector<Eigen::Isometry3d> T_w_k;
  for (const Keyframe& k : trajectory.keyframes) T_w_k.push_back(k.T_w_c.T);
  return keyframeGraph(T_w_k, trajectory.motions, mounting, MappingParams().odometry.key_distance);
}

}  // namespace facetloc::internal
