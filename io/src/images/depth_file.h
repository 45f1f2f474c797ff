// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/io/camera_file.h>
#include <facetloc/io/png.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/** \file
 * Depth images in files of one image each, but for clouds, and images of other files. All functions throw
 * IoError. Private to io. */

namespace facetloc {

/** \brief The values of a depth image, row by row. */
struct StoredDepth {
  int width = 0;
  int height = 0;
  std::vector<float> metres{};           ///< values of floating-point images; or empty
  std::vector<std::uint16_t> numbers{};  ///< values of others, by the depth scale; or empty
};

constexpr std::uint16_t kNotMeasured = 65535;  ///< value beside 0, of 7-Scenes and some drivers

/** \brief The values of a raster. */
inline StoredDepth storedIn(Raster<std::uint16_t> raster) {
  return {raster.width, raster.height, {}, std::move(raster.data)};
}
/** \brief Depth by values and their scale [1/m]; 0 where it was not measured. */
std::vector<float> metresOf(const std::vector<std::uint16_t>& values, double scale);

/** \brief The size of an image that a file may promise at most [px]. */
constexpr std::uint64_t kMostPixels = 1ull << 26;
/** \brief Throws IoError for an image without pixels, or with more than any has. */
void requireSize(const std::string& source, std::uint64_t width, std::uint64_t height);

/** \brief A number of a file in the order of bytes of this machine, which is little-endian. */
template <typename T>
T numberAt(const char* bytes, bool big_endian) {
  std::array<char, sizeof(T)> ordered;
  std::copy(bytes, bytes + sizeof(T), ordered.begin());
  if (big_endian) std::reverse(ordered.begin(), ordered.end());
  T value;
  std::memcpy(&value, ordered.data(), sizeof value);
  return value;
}

/** \brief Endings of such files, for messages: ".png, .pclzf, ...". */
std::string depthFileEndings();
/** \brief Is it one, by its name? */
bool isDepthFile(const std::filesystem::path& path);
/** \brief The size of an image by the head of its file; empty if it is no such file. */
std::optional<PngSize> depthFileSize(const std::filesystem::path& path);

/** \brief Reads any of these. Floating-point depth is in metres, or in millimetres if most of it would be
 * beyond 100 m, and may be negative throughout. Throws IoError. */
StoredDepth readDepthValues(const std::filesystem::path& path);

// Formats.

/** \brief One image of one channel: 16 bits, or floating point of 32 or 64 bits. */
StoredDepth readTiff(const std::filesystem::path& path);
/** \brief NumPy's format: one array of H x W, or with a further side of 1, of u2, i2, u4, i4, f2, f4 or f8.
 */
StoredDepth readNpy(const std::filesystem::path& path);
/** \brief Netpbm's grey images, P5, of 16 bits. */
StoredDepth readPgm(const std::filesystem::path& path);
/** \brief Portable float maps of one channel, Pf, whose rows are stored from the bottom up. */
StoredDepth readPfm(const std::filesystem::path& path);

// PNGs that are part of another file.

/** \brief As readGreyPng() of a file. \param name of the PNG in errors */
Raster<std::uint16_t> readGreyPng(const std::uint8_t* data, std::size_t size, const std::string& name,
                                  int min_bits);

/** \brief A PNG of 8 bits with four channels: red, green, blue, alpha. */
Raster<std::uint8_t> readRgbaPng(const std::uint8_t* data, std::size_t size, const std::string& name);
/** \brief Is it one with these four channels, by its head? */
bool isRgbaPng(const std::uint8_t* data, std::size_t size);

/** \brief A grey image and the value that is white in it. */
struct Greymap {
  Raster<std::uint16_t> image;
  int white = 255;
};

/** \brief Parses a PGM of 8 or 16 bits, binary (P5) or in decimal numbers (P2). Throws IoError. */
Greymap parsePgm(const std::string& source, std::string_view bytes);

/** \brief Writes a binary PGM of 8 bits, atomically. Throws IoError. */
void writePgm(const std::filesystem::path& path, const Raster<std::uint8_t>& image);

}  // namespace facetloc
