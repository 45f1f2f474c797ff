// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera.h>

#include <string>
#include <string_view>
#include <vector>

namespace facetloc {

/** \brief What is known of a kind of depth camera. SENSORS.md tells where the numbers come from. */
struct CameraPreset {
  const char* name;       ///< in camera.ini and on command lines, such as "azure_kinect"
  const char* title;      ///< in words
  Intrinsics intrinsics;  ///< of a typical device: plausible, but no calibration of yours
  SensorNoise noise;
  double max_depth;  ///< farther depths are wrong [m]; infinite for cameras that report none

  /** \brief The camera, without the intrinsics, which each device has of its own. */
  Camera camera() const;
};

/** \brief All presets, the default first. */
const std::vector<CameraPreset>& cameraPresets();

/** \brief Null if there is none of that name. */
const CameraPreset* findCameraPreset(std::string_view name);

/** \brief "kinect, xtion, ...", for messages. */
std::string cameraPresetNames();

}  // namespace facetloc
