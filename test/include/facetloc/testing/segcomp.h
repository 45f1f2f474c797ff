// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/png.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace facetloc::test {

/** \brief A range image of the SegComp benchmark with its true regions. */
struct SegCompImage {
  std::string name;
  DepthImage depth;
  Raster<std::uint16_t> truth;
};

/** \brief Reads a folder of calibration.csv (name, fx, fy, cx, cy, depth_scale), depth/ and labels/. */
inline std::vector<SegCompImage> readSegComp(const std::filesystem::path& folder) {
  std::ifstream calibration(folder / "calibration.csv");
  std::string line;
  std::getline(calibration, line);  // header
  std::vector<SegCompImage> images;
  while (std::getline(calibration, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream fields(line);
    SegCompImage image;
    CameraFile camera;
    Intrinsics& c = camera.camera.intrinsics;
    fields >> image.name >> c.fx >> c.fy >> c.cx >> c.cy >> camera.depth_scale;
    image.truth = readGreyPng(folder / "labels" / (image.name + ".png"));
    c.width = image.truth.width;
    c.height = image.truth.height;
    image.depth = readDepthPng(folder / "depth" / (image.name + ".png"), camera);
    images.push_back(std::move(image));
  }
  return images;
}

}  // namespace facetloc::test
