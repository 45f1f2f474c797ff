// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "temporary_folder.h"

#include <facetloc/io/depth_sequence.h>

#include <cstdio>

namespace facetloc::test {

/** \brief Synthetic depth images that all differ, with holes; depth in whole millimetres. */
struct ExampleSequence {
  int frames = 20;
  double rate = 100;          ///< [Hz]
  double first_stamp = 1000;  ///< [s]
  Intrinsics camera{64, 48, 58.5, 58.6, 31.9, 25.6};

  double stamp(int i) const { return first_stamp + i / rate; }
  std::string name(int i) const {
    char text[64];
    std::snprintf(text, sizeof text, "%.6f", stamp(i));
    return text;
  }
  int millimetres(int i, int u, int v) const { return (u + v) % 7 == 0 ? 0 : 600 + 13 * i + 5 * u + 11 * v; }
  DepthImage image(int i) const {
    DepthImage out{camera, {}};
    for (int v = 0; v < camera.height; ++v)
      for (int u = 0; u < camera.width; ++u)
        out.depth.push_back(static_cast<float>(millimetres(i, u, v) / 1000.0));
    return out;
  }
  std::filesystem::path image(const std::filesystem::path& folder, int i) const {
    return folder / "depth" / (name(i) + ".png");
  }
  std::filesystem::path write(const std::filesystem::path& folder) const {
    std::filesystem::create_directories(folder / "depth");
    CameraFile file;
    file.camera.intrinsics = camera;
    file.depth_scale = 1000;
    writeCameraFile(folder / "camera.ini", file);
    for (int i = 0; i < frames; ++i) writeDepthPng(image(folder, i), image(i), file.depth_scale);
    return folder;
  }
};

}  // namespace facetloc::test
