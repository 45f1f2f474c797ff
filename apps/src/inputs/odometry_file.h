// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"

#include <facetloc/features/camera_model.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/mapping/map_image.h>

#include <optional>
#include <string>

namespace facetloc {

/** \brief An odometry, in the axes of the camera, interpolated between its poses: lines of JSON as
 * facetloc_live takes them (ROBOT.md), each with its stamp, or any file of poses, which are those of the
 * camera, or of its robot if the mounting is known; or a recording of messages. Empty for an empty name, with
 * a remark on how the poses were read. Throws IoError with file, line and cause. \param sequence whose images
 * it moves */
PosesByTime odometryByTime(const std::string& file, const DepthSequence& sequence,
                           const std::optional<CameraMounting>& mounting, const Console& console);

}  // namespace facetloc
