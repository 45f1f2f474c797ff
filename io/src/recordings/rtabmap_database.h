// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recordings/image_container.h"

#include <filesystem>
#include <memory>

/** \file
 * Databases of RTAB-Map. Private to io. */

namespace facetloc::internal {

/** \brief The depth images of a database of RTAB-Map (0.12 or newer), with the poses of its optimised graph,
 * or of its odometry where no graph was saved, and the camera of its first image. Throws IoError, also for
 * stereo images and for several cameras in one image. */
std::shared_ptr<const ImageContainer> openRtabmapDatabase(const std::filesystem::path& path);

}  // namespace facetloc::internal
