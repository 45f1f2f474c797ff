// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera.h>
#include <facetloc/features/lens_distortion.h>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace facetloc {

/** \brief The camera.ini of a depth sequence: one `key = value` per line, # starts a comment.
 *
 *     width=640  height=480  fx=525  fy=525  cx=319.5  cy=239.5  depth_scale=5000
 *     k1=4.72  k2=3.21  p1=0  p2=0  k3=0.17  k4=5.06  k5=4.78  k6=0.89     optional, see LensDistortion
 *     depth_is=distance                          optional: along the ray, instead of z
 *     mount_height=0.98  mount_tilt_deg=10       optional, both or none, and with them
 *     mount_roll_deg=0  mount_pan_deg=0  mount_x=0.2  mount_y=0       optional, see CameraMounting
 *     camera=azure_kinect                        optional: noise and largest depth of a CameraPreset
 *     inverse_depth_std=0.00142                  optional, see SensorNoise, as are
 *     depth_std=0.001  depth_std_slope=0.001  distortion_offset=0.0007  distortion_slope=0.0014
 *     correlation_px=4
 *     max_depth=5                                optional: farther pixels count as not measured [m]
 *
 * (several pairs on one line are accepted, as written here). Keys override the preset. A
 * negative fy, as ICL-NUIM's, says that the y axis of the camera points up in the recording's poses. */
struct CameraFile {
  Camera camera;              ///< without distortion; noise and mounting as far as they are given
  double depth_scale = 1000;  ///< PNG value per metre
  std::string preset{};       ///< the CameraPreset that is named; empty if none is
  bool y_axis_up =
      false;  ///< direction of the y axis in its poses; its images have their first row on top all the same
  LensDistortion lens{};  ///< lens of the images as stored; images that are read are a pinhole camera's
  DepthKind depth_is = DepthKind::z;  ///< meaning of the images as stored

  /** \brief Are the images as they are stored those of a pinhole camera? */
  bool isPinhole() const { return lens.isNone() && depth_is == DepthKind::z; }
};

/** \brief Throws IoError with the line for unknown keys and presets, missing keys, values that are no numbers
 * or impossible. */
CameraFile readCameraFile(const std::filesystem::path& path);
void writeCameraFile(const std::filesystem::path& path, const CameraFile& camera);

/** \brief Keys of a camera.ini with their values, as text. */
using CameraKeys = std::vector<std::pair<std::string, std::string>>;

/** \brief Is it a key of a camera.ini? */
bool isCameraKey(std::string_view key);

/** \brief The camera that programs describe by the keys of a camera.ini, of which some may be left out:
 * depth_scale, which then is 1000, and all of fx, fy, cx, cy if `camera` names a preset with images of that
 * size, whose typical intrinsics hold. Throws IoError as readCameraFile(), without a line.
 * \param name of who describes it, for errors */
CameraFile cameraOfKeys(CameraKeys keys, const std::string& name);

/** \brief The keys and values that writeCameraFile() writes: cameraOfKeys() makes the same camera of them.
 * Throws std::invalid_argument for an impossible camera. */
CameraKeys keysOfCamera(const CameraFile& camera);

/** \brief Is it a map file, by its first bytes? False if it cannot be read. */
bool isMapFile(const std::filesystem::path& path);

/** \brief The camera that a map was made with, for other images of the same camera: intrinsics, noise,
 * largest depth and mounting, without the distortion that the map has found (Map::calibrated() adds it).
 * \param stored how the other images are stored, if that is known: its depth scale, lens and axes are kept,
 * and its intrinsics where the map has none. Throws IoError if it is no map, and if nothing gives the
 * intrinsics. */
CameraFile cameraOfMap(const std::filesystem::path& map, const std::optional<CameraFile>& stored = {});

/** \brief The camera that a user names where there are no images: by a camera.ini, a map that was made with
 * it, or the name of a CameraPreset, whose intrinsics are those of a typical device. Throws IoError. */
Camera cameraNamed(const std::string& file_or_name);

}  // namespace facetloc
