// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recordings/pose_table.h"

#include <facetloc/io/gravity_record.h>
#include <facetloc/io/trajectory.h>

#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace facetloc::internal {

class MessageLog;

/** \brief A pose of a message. Throws IoError. \param columns tx ty tz qx qy qz qw \param name of the file */
StampedPose poseOf(double stamp, const std::array<double, 7>& columns, const std::string& name);

/** \brief The odometry of a recording: nav_msgs/Odometry, or else the poses of the frame odom in tf, or of
 * the only frame that moves above the camera. Throws IoError without one. \param camera_frame the frame of
 * the depth images; where tf has it fixed below the frame that moves, the poses are the camera's, and else
 * those of that frame, as of the robot's base. Empty: they are the latter */
ReadPoses readMessageOdometry(const std::filesystem::path& path, const std::string& camera_frame);

/** \brief Gravity, and a remark on its source: a sentence without full stop, or nothing. */
struct ReadGravity {
  GravityRecord gravity;
  std::string remark{};
};

/** \brief Gravity in the optical frame of the camera at the times of images, by the accelerometer of an IMU
 * (sensor_msgs/Imu) whose orientation is known by tf, or the names of the frames: the mean of its
 * measurements half a second before and after. Where the mean is longer or shorter than gravity, the camera
 * is accelerated: the standard deviation grows by their difference, and beyond a fifth there is no gravity.
 * Empty without an IMU. Throws IoError for corrupt messages. \param std of its direction [rad] */
ReadGravity readImuGravity(const MessageLog& log, const std::string& camera_frame,
                           const std::vector<double>& stamps, double std);

}  // namespace facetloc::internal
