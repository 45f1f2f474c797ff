// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/command_line.h"

#include <facetloc/features/camera_model.h>
#include <facetloc/features/pose.h>

#include <optional>
#include <string>

namespace facetloc {

/** \brief The option --near of tools that follow a camera. */
void addStartOption(CommandLine& line, std::string& text);

/** \brief The pose of a camera from "x,y,z,yaw_deg[,std_m[,std_deg]]": its position in the world [m], and the
 * direction that it looks in, seen from above, from the x axis counterclockwise. It is tilted and rolled as
 * its mounting says, else level. Nothing for an empty text. Throws UsageError. */
std::optional<PoseWithCovariance> startPose(const std::string& near,
                                            const std::optional<CameraMounting>& mounting);

}  // namespace facetloc
