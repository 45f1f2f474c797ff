// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/message_poses.h"

#include "recordings/frame_tree.h"
#include "results/pose_columns.h"

#include <facetloc/io/error.h>

#include <fmt/format.h>

namespace facetloc::internal {
namespace {

/** Poses of one topic. \param remark the number of messages left out is added */
FrameTree::Moving odometryOf(const MessageLog& log, const std::string& topic, std::string& remark) {
  FrameTree::Moving moving;
  const std::string fault = log.readSound<OdometryMessage>(topic, [&](const OdometryMessage& message) {
    moving.poses.push_back(poseOf(message.header.stamp, message.pose, log.path().string()));
    moving.parent = message.header.frame, moving.child = message.child_frame;
  });
  addSentence(fault, remark);
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
    moving = odometryOf(log, topics.front().name, read.remark);  // they are sorted by their names
    if (topics.size() > 1)
      addSentence(fmt::format("{}: the odometry is from {}, the first of {}", path.string(),
                              topics.front().name, listOf(topics)),
                  read.remark);
  } else {
    moving = tree.moving(camera_frame);
  }
  addSentence(tree.faults(), read.remark);
  if (!moving || moving->poses.empty())
    throw IoError(path.string(),
                  "has no odometry: no message nav_msgs/Odometry, and no transform of odom in /tf" +
                      (read.remark.empty() ? "" : "; " + read.remark));
  if (const auto T = camera_frame.empty() ? std::nullopt : tree.fixed(moving->child, camera_frame)) {
    for (StampedPose& pose : moving->poses) pose.T_w_c = pose.T_w_c * *T;
    addSentence(fmt::format("{}: by tf, poses of {} are those of the camera, {}", path.string(),
                            moving->child, camera_frame),
                read.remark);
  }
  read.poses = Trajectory(std::move(moving->poses));
  return read;
}

}  // namespace facetloc::internal
