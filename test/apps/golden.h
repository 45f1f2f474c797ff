// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/io/png.h>
#include <facetloc/testing/places.h>

#include <gtest/gtest.h>
#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace facetloc::test {

/** \brief Reads a PNG as RGB. */
inline Raster<std::uint8_t> readRgbPng(const std::filesystem::path& path) {
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_file(&image, path.c_str()))
    throw std::runtime_error(path.string() + ": " + image.message);
  image.format = PNG_FORMAT_RGB;
  Raster<std::uint8_t> picture{static_cast<int>(image.width), static_cast<int>(image.height), 3, {}};
  picture.data.resize(PNG_IMAGE_SIZE(image));
  if (!png_image_finish_read(&image, nullptr, picture.data.data(), 0, nullptr))
    throw std::runtime_error(path.string() + ": " + image.message);
  return picture;
}

/** \brief Largest difference of the channels of two pixels. */
inline int pixelDifference(const Raster<std::uint8_t>& a, int ua, int va, const Raster<std::uint8_t>& b,
                           int ub, int vb) {
  int largest = 0;
  for (int c = 0; c < 3; ++c)
    largest = std::max(largest, std::abs(a.data[(static_cast<std::size_t>(va) * a.width + ua) * 3 + c] -
                                         b.data[(static_cast<std::size_t>(vb) * b.width + ub) * 3 + c]));
  return largest;
}

/** \brief Pixels of a for which b has nothing like them in the same place or beside it: edges may be one
 * pixel off and be smoothed otherwise, but nothing may be missing or of another colour. */
inline int strangePixels(const Raster<std::uint8_t>& a, const Raster<std::uint8_t>& b) {
  constexpr int kAlike = 32;
  int strange = 0;
  for (int v = 0; v < a.height; ++v)
    for (int u = 0; u < a.width; ++u) {
      int least = 255;
      for (int y = std::max(0, v - 1); y <= std::min(a.height - 1, v + 1); ++y)
        for (int x = std::max(0, u - 1); x <= std::min(a.width - 1, u + 1); ++x)
          least = std::min(least, pixelDifference(a, u, v, b, x, y));
      strange += least > kAlike;
    }
  return strange;
}

/** \brief The folder of the golden pictures. FACETLOC_UPDATE_GOLDEN=1 in the environment writes them anew. */
inline std::filesystem::path goldenPath(const std::string& name) {
  return std::filesystem::path(kGoldenFolder) / (name + ".png");
}
inline bool updatesGolden() { return std::getenv("FACETLOC_UPDATE_GOLDEN") != nullptr; }

/** \brief The picture equals the golden one in every pixel. */
inline void expectGolden(const std::string& name, const Raster<std::uint8_t>& picture) {
  if (updatesGolden()) return writePng(goldenPath(name), picture);
  const Raster<std::uint8_t> golden = readRgbPng(goldenPath(name));
  ASSERT_EQ(golden.width, picture.width);
  ASSERT_EQ(golden.height, picture.height);
  EXPECT_TRUE(golden.data == picture.data) << name << " is not as it was";
}

/** \brief The picture looks like the golden one, whatever OpenGL rendered it. */
inline void expectLikeGolden(const std::string& name, const Raster<std::uint8_t>& picture) {
  if (updatesGolden()) return writePng(goldenPath(name), picture);
  constexpr double kMeanDifference = 1.0;  // grey levels
  constexpr int kStrange = 4;              // pixels
  const Raster<std::uint8_t> golden = readRgbPng(goldenPath(name));
  ASSERT_EQ(golden.width, picture.width);
  ASSERT_EQ(golden.height, picture.height);
  double sum = 0;
  for (std::size_t i = 0; i < golden.data.size(); ++i) sum += std::abs(golden.data[i] - picture.data[i]);
  EXPECT_LT(sum / static_cast<double>(golden.data.size()), kMeanDifference) << name;
  EXPECT_LE(strangePixels(golden, picture), kStrange) << name << ": something is missing";
  EXPECT_LE(strangePixels(picture, golden), kStrange) << name << ": something is new";
}

}  // namespace facetloc::test
