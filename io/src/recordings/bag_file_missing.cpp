// SPDX-License-Identifier: BSD-3-Clause
// Replaces bag_file.cpp where there is no rosbag_storage.
#include "recordings/message_file.h"

#include <facetloc/io/error.h>

namespace facetloc::internal {

std::unique_ptr<const MessageFile> openRos1Bag(const std::filesystem::path& path) {
  throw IoError(path.string(),
                "is a bag of ROS 1, which this build of facetloc cannot read: install librosbag-storage-dev, "
                "librcpputils-dev and libament-index-cpp-dev, and build it anew");
}

}  // namespace facetloc::internal
