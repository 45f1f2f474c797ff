// SPDX-License-Identifier: BSD-3-Clause
#include "trajectory/levelled_trajectory.h"

#include <map>

namespace facetloc::internal {

void levelTrajectory(const std::function<std::optional<Gravity>(std::size_t image)>& gravity,
                     CameraTrajectory& trajectory) {
  const auto partOf = [&](const TrajectoryPose& pose) {
    return trajectory.keyframes[static_cast<std::size_t>(pose.keyframe)].part;
  };
  std::map<int, Eigen::Vector3d> down;  // direction in each part, weighted by accuracy
  for (std::size_t i = 0; i < trajectory.images.size(); ++i) {
    const TrajectoryPose& pose = trajectory.images[i];
    const auto measured = gravity(i);
    if (!measured || !measured->valid()) continue;
    const Eigen::Vector3d in_world = pose.T_w_c.linear() * measured->down;
    down.try_emplace(partOf(pose), Eigen::Vector3d::Zero()).first->second +=
        in_world / (measured->std * measured->std);
  }
  const auto level = [&](int part) {
    const auto found = down.find(part);
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    if (found != down.end() && found->second.norm() > 0)
      T.linear() = rotationBetween(found->second.normalized(), -Eigen::Vector3d::UnitZ());
    return T;
  };
  for (TrajectoryPose& pose : trajectory.images) pose.T_w_c = level(partOf(pose)) * pose.T_w_c;
  for (Keyframe& keyframe : trajectory.keyframes) keyframe.T_w_c = level(keyframe.part) * keyframe.T_w_c;
}

}  // namespace facetloc::internal
