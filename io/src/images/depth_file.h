// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/io/camera_file.h>
#include <facetloc/io/png.h>

#include <filesystem>
#include <optional>
#include <vector>

/** \file
 * Depth images in files of one image each, but for clouds. Private to io. */

namespace facetloc {

/** \brief The values of a depth image, row by row. */
struct StoredDepth {
  int width = 0;
  int height = 0;
  std::vector<float> metres{};           ///< values of floating-point images; or empty
  std::vector<std::uint16_t> numbers{};  ///< values of others, by the depth scale; or empty
};

/** \brief The size of an image that a file may promise at most [px]. */
constexpr std::uint64_t kMostPixels = 1ull << 26;

/** \brief Endings of such files, ".png" first. */
const std::vector<const char*>& depthFileEndings();
/** \brief Is it one, by its name? */
bool isDepthFile(const std::filesystem::path& path);
/** \brief The size of an image by the head of its file; empty if it is no such file. */
std::optional<PngSize> depthFileSize(const std::filesystem::path& path);

/** \brief Reads any of these. Floating-point depth is in metres, or in millimetres if most of it would be
 * beyond 100 m, and may be negative throughout. Throws IoError. */
StoredDepth readDepthValues(const std::filesystem::path& path);

// Formats. All throw IoError.

/** \brief One image of one channel: 16 bits, or floating point of 32 or 64 bits. */
StoredDepth readTiff(const std::filesystem::path& path);
/** \brief NumPy's format: one array of H x W, or with a further side of 1, of u2, i2, u4, i4, f2, f4 or f8.
 */
StoredDepth readNpy(const std::filesystem::path& path);
/** \brief Netpbm's grey images, P5, of 16 bits. */
StoredDepth readPgm(const std::filesystem::path& path);
/** \brief Portable float maps of one channel, Pf, whose rows are stored from the bottom up. */
StoredDepth readPfm(const std::filesystem::path& path);

}  // namespace facetloc
