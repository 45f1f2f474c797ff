// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera.h>

#include <filesystem>

namespace facetloc {

/** \brief The camera.ini of a depth sequence: one `key = value` per line, # starts a comment.
 *
 *     width=640  height=480  fx=525  fy=525  cx=319.5  cy=239.5  depth_scale=5000
 *     mount_height=0.98  mount_tilt_deg=10       optional, both or none
 *     inverse_depth_std=0.00142                  optional, see SensorNoise
 *
 * (several pairs on one line are accepted, as written here). */
struct CameraFile {
  Camera camera;              ///< without distortion; noise and mounting as far as they are given
  double depth_scale = 1000;  ///< PNG value per metre
};

/** \brief Throws IoError with the line for unknown keys, missing keys, values that are no numbers or
 * impossible. */
CameraFile readCameraFile(const std::filesystem::path& path);
void writeCameraFile(const std::filesystem::path& path, const CameraFile& camera);

}  // namespace facetloc
