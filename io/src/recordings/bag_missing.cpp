// SPDX-License-Identifier: BSD-3-Clause
// In the place of bag.cpp, where there is no rosbag_storage.
#include "recordings/bag.h"

#include <facetloc/io/error.h>

namespace facetloc::internal {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& path) {
  throw IoError(path.string(),
                "is a ROS bag, which this build of facetloc cannot read: install librosbag-storage-dev, "
                "libsensor-msgs-dev, libnav-msgs-dev and libtf2-msgs-dev, and build it anew");
}

}  // namespace

std::shared_ptr<const ImageContainer> openBag(const std::filesystem::path& path, const std::string&) {
  refuse(path);
}

Trajectory readBagOdometry(const std::filesystem::path& path) { refuse(path); }

}  // namespace facetloc::internal
