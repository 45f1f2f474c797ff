// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/io/camera_file.h>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace facetloc {

/** \brief Keys of a camera.ini with their values, as text. */
using CameraKeys = std::vector<std::pair<std::string, std::string>>;

/** \brief Is it a key of a camera.ini? */
bool isCameraKey(std::string_view key);

/** \brief The camera that programs describe by the keys of a camera.ini, of which some may be left out:
 * depth_scale, which then is 1000, and all of fx, fy, cx, cy if `camera` names a preset with images of that
 * size, whose typical intrinsics hold. Throws IoError as readCameraFile(), without a line.
 * \param name of who describes it, for errors */
CameraFile cameraOfKeys(CameraKeys keys, const std::string& name);

}  // namespace facetloc
