// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recordings/message_log.h"

#include <facetloc/io/camera_file.h>

#include <cstdint>
#include <string>

/** \file
 * The camera of depth images in messages. Private to io. */

namespace facetloc::internal {

/** \brief Images whose camera is looked for. */
struct ImagesOfTopic {
  std::string topic;                    ///< topic of the plain images
  std::string frame;                    ///< frame of their headers; may be empty
  std::uint32_t width = 0, height = 0;  ///< [px], or 0 if not known
};

/** \brief A camera, without intrinsics if no message has them. */
struct MessageCamera {
  CameraFile file;
  std::string remark{};  ///< source of the camera, and the treatment of its lens; or nothing
};

/** \brief Camera by the CameraInfo next to the images, or else by one of the same frame and size. RealSense's
 * own recorder also has the unit of depth. Throws IoError for corrupt messages. */
MessageCamera cameraOfMessages(const MessageLog& log, const ImagesOfTopic& images);

}  // namespace facetloc::internal
