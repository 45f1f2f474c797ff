// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/io/camera_file.h>

#include <filesystem>
#include <optional>
#include <string>

namespace facetloc {

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
