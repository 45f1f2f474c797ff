// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/io/camera_file.h>

#include <string>
#include <utility>
#include <vector>

namespace facetloc::internal {

/** \brief Is it a key of a camera.ini? */
bool isCameraKey(std::string_view key);

/** \brief What a camera.ini of these keys and values says. Throws IoError as readCameraFile(), without a
 * line. \param name of where they are written */
CameraFile cameraOfPairs(const std::vector<std::pair<std::string, std::string>>& pairs,
                         const std::string& name);

}  // namespace facetloc::internal
