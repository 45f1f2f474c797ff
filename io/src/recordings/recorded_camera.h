// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recordings/recording_layout.h"

#include <facetloc/features/camera_presets.h>
#include <facetloc/io/camera_file.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

/** \file
 * Which camera took a recording. Private to io. */

namespace facetloc::internal {

/** \brief A camera, and how it was found. */
struct RecordedCamera {
  CameraFile file;
  std::string remark{};  ///< where it is from, if not from a camera.ini or the user
};

/** \brief A camera with the noise and largest depth of a preset. */
CameraFile cameraFileOf(const Intrinsics& intrinsics, double depth_scale, const CameraPreset& preset);

/** \brief The camera by the files of a recording: camera.ini, else a matrix of intrinsics as 3DMatch
 * and ScanNet have it, the .xml of PCL's recorders, the camera of a phone, or a calibration in YAML or JSON
 * of the size of the images; else, in a public data set's layout, the known camera of that data set. Empty if
 * none of these is there. Throws IoError. \param beside folders to look in; \param within those of them that
 * are the recording's own; \param asked the folder of the recording */
std::optional<RecordedCamera> cameraOf(const RecordingLayout& layout,
                                       const std::vector<std::filesystem::path>& beside,
                                       const std::vector<std::filesystem::path>& within,
                                       const std::filesystem::path& asked);

/** \brief The camera of which a user names the CameraPreset: its noise and largest depth count more than
 * those of the recording, and its intrinsics are a typical device's if the recording has none. Throws
 * IoError. \param recorded by the files of the recording, if they say it */
RecordedCamera withPreset(const std::string& name, const std::optional<RecordedCamera>& recorded,
                          const RecordingLayout& layout);

/** \brief Advice on images with an unknown camera, with the lines of a camera.ini to paste. */
std::string adviceOnCamera(const RecordingLayout& layout, const std::filesystem::path& asked);

}  // namespace facetloc::internal
