// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/message_poses.h"

#include "pose_columns.h"
#include "recordings/frame_tree.h"

#include <facetloc/io/error.h>

#include <fmt/format.h>

namespace facetloc::internal {
namespace {

/** Of one topic; of several the first by its name, as they are sorted. */
FrameTree::Moving odometryOf(const MessageLog& log, const std::string& topic) {
  FrameTree::Moving moving;
  log.readAll<OdometryMessage>(topic, [&](const OdometryMessage& message) {
    moving.parent = message.header.frame, moving.child = message.child_frame;
    moving.poses.push_back(poseOf(message.header.stamp, message.pose, log.path().string()));
  });
  return moving;
}

}  // namespace

StampedPose poseOf(double stamp, const std::array<double, 7>& columns, const std::string& name) {
  constexpr double kTolerance = 1e-2;  // tolerance of |q|^2
  const auto T = fromColumns(columns, kTolerance);
  if (!T) throw IoError(name, std::string("has a pose that ") + faultOf(columns, kTolerance));
  return {stamp, *T};
}

ReadPoses readMessageOdometry(const std::filesystem::path& path, const std::string& camera_frame) {
  const MessageLog log(path);
  const auto topics = log.topicsOf(OdometryMessage::kType);
  const FrameTree tree(log);
  std::optional<FrameTree::Moving> moving;
  ReadPoses read;
  if (!topics.empty()) {
    moving = odometryOf(log, topics.front().name);
    if (topics.size() > 1)
      read.remark = fmt::format("{}: the odometry is from {}, the first of {}", path.string(),
                                topics.front().name, listOf(topics));
  } else {
    moving = tree.moving(camera_frame);
  }
  if (!moving || moving->poses.empty())
    throw IoError(path.string(),
                  "has no odometry: no message nav_msgs/Odometry, and no transform of odom in /tf");
  if (const auto T = camera_frame.empty() ? std::nullopt : tree.fixed(moving->child, camera_frame)) {
    for (StampedPose& pose : moving->poses) pose.T_w_c = pose.T_w_c * *T;
    read.remark += fmt::format("{}{}: by tf, poses of {} are those of the camera, {}",
                               read.remark.empty() ? "" : "; ", path.string(), moving->child, camera_frame);
  }
  read.poses = Trajectory(std::move(moving->poses));
  return read;
}

}  // namespace facetloc::internal
