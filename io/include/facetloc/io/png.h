// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

namespace facetloc {

/** \brief A raster, row-major, top row first, channels interleaved. */
template <typename T>
struct Raster {
  int width = 0;
  int height = 0;
  int channels = 1;
  std::vector<T> data;
};

/** \brief Reads a greyscale PNG of 8 or 16 bits, or of 16 bits only. Throws IoError for anything else and for
 * truncated or corrupt files. */
Raster<std::uint16_t> readGreyPng(const std::filesystem::path& path, int min_bits = 8);
/** \brief The size of an image by the head of its PNG. */
struct PngSize {
  int width = 0;
  int height = 0;
  int bits = 0;  ///< depth of each channel
};
/** \brief Nothing if it is no PNG. */
std::optional<PngSize> pngSize(const std::filesystem::path& path);
/** \brief Writes a 16-bit greyscale PNG, atomically. */
void writePng(const std::filesystem::path& path, const Raster<std::uint16_t>& image);
/** \brief Writes an 8-bit PNG, greyscale (1 channel) or RGB (3 channels), atomically. */
void writePng(const std::filesystem::path& path, const Raster<std::uint8_t>& image);

}  // namespace facetloc
