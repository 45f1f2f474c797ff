// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recordings/image_container.h"

#include <filesystem>
#include <memory>
#include <string>

/** \file
 * Recordings of ROS 1 and ROS 2. Private to io. */

namespace facetloc::internal {

/** \brief The depth images of a recording of messages: sensor_msgs/Image with 16UC1, mono16 [mm] or 32FC1
 * [m], or CompressedImage of the format compressedDepth, and the CameraInfo that belongs to them, as ROS's
 * drivers and RealSense's own recorder have them.
 * \param topic empty = of several, the one that is called depth and has the most images, and of one that is
 * there plain and compressed, the plain one
 * Throws IoError. */
std::shared_ptr<const ImageContainer> openMessageRecording(const std::filesystem::path& path,
                                                           const std::string& topic);

}  // namespace facetloc::internal
