// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace facetloc {

/** \brief Facts about a kind of depth camera. SENSORS.md has their sources.
 *
 * Its noise is not among them: each image is measured for its own noise, and telling it beforehand has found
 * fewer places on recordings of real devices, not more (SENSORS.md). */
struct CameraPreset {
  const char* name;   ///< name for camera.ini and command lines, such as "azure_kinect"
  const char* title;  ///< name for people
  /** Intrinsics of a typical device by mode, the usual mode first: plausible, but no calibration of yours. */
  std::vector<Intrinsics> modes;
  double min_depth;  ///< nearest depth measured [m]
  double max_depth;  ///< farther depths are wrong [m]; infinite for cameras that report none

  const Intrinsics& intrinsics() const { return modes.front(); }
  /** \brief The camera, without the intrinsics, which each device has of its own. */
  Camera camera() const;
  /** \brief Intrinsics of a typical device for images of this size [px]: of the mode of that size, or of one
   * of that shape, also turned by 90 deg. Nothing for other images. */
  std::optional<Intrinsics> intrinsicsOf(int width, int height) const;
  /** \brief True for the size of one of its modes, also turned by 90 deg. */
  bool hasMode(int width, int height) const;
};

/** \brief All presets, the default first. */
const std::vector<CameraPreset>& cameraPresets();

/** \brief The first preset that has a mode of this size [px]; else the first with a mode of this shape; else
 * the default. */
const CameraPreset& cameraPresetFor(int width, int height);

/** \brief Null for an unknown name. */
const CameraPreset* findCameraPreset(std::string_view name);

/** \brief "kinect, xtion, ...", for messages. */
std::string cameraPresetNames();

}  // namespace facetloc
