// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recordings/image_container.h"

#include <facetloc/io/trajectory.h>

#include <filesystem>
#include <memory>
#include <string>

/** \file
 * ROS 1 bags. Where the build has no rosbag_storage, both functions throw an IoError that says so.
 * Private to io. */

namespace facetloc::internal {

/** \brief The depth images of a bag: messages sensor_msgs/Image with 16UC1, mono16 [mm] or 32FC1 [m], and the
 * CameraInfo beside them, as ROS's drivers and RealSense's own recorder have them.
 * \param topic empty = of several, the one that is called depth and has the most images
 * Throws IoError. */
std::shared_ptr<const ImageContainer> openBag(const std::filesystem::path& path, const std::string& topic);

/** \brief The poses of a robot's base by its odometry: nav_msgs/Odometry, or else what tf has of the frame
 * odom. Throws IoError if the bag has neither. */
Trajectory readBagOdometry(const std::filesystem::path& path);

}  // namespace facetloc::internal
