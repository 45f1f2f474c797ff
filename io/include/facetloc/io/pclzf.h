// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>
#include <facetloc/io/png.h>

#include <cstdint>
#include <filesystem>

namespace facetloc {

// The compressed images of PCL's recorders: frame_<time>_depth.pclzf, and the camera of each,
// frame_<time>.xml.

/** \brief Reads a depth image. Throws IoError. */
Raster<std::uint16_t> readPclzf(const std::filesystem::path& path);

/** \brief The depth camera of such a recording. */
struct PclzfCamera {
  Intrinsics intrinsics;      ///< intrinsics of the given size
  double depth_scale = 1000;  ///< values per metre
};

/** \brief Reads the .xml file of a camera, which does not tell the size of its images. Throws IoError. */
PclzfCamera readPclzfCamera(const std::filesystem::path& path, int width, int height);

}  // namespace facetloc
