// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/io/depth_sequence.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

/** \file
 * The inputs of results, so that --resume does not mix those of different inputs. */

namespace facetloc {

/** \brief The sizes of image files [bytes], by their names; they distinguish recordings whose files have the
 * same names. */
using ImageSizes = std::map<std::string, std::uintmax_t>;
/** \brief The key in a map's meta of the sizes of the images that it was built of. */
constexpr const char* kImagesKey = "images";
/** \brief The key of how far the building of a map has come; kUnderWay until it is whole. */
constexpr const char* kStateKey = "state";
constexpr const char* kUnderWay = "under way";
constexpr const char* kWhole = "whole";
/** \brief 0 if it is no regular file. */
std::uintmax_t sizeOf(const FrameFile& image);
ImageSizes imageSizes(const DepthSequence& sequence);
/** \brief One image per line. */
std::string toText(const ImageSizes& sizes);
/** \brief The sizes again. */
ImageSizes imageSizes(const std::string& text);

/** \brief A comment line for params.ini. */
std::string cameraLine(const std::optional<CameraFile>& file);
/** \brief CRC-32 of a file, in hexadecimal digits. Throws IoError. */
std::string checksum(const std::filesystem::path& file);

/** \brief The inputs and parameters of the results in a folder: its params.ini and images.txt. */
struct Provenance {
  std::string params_ini;
  ImageSizes images;

  /** \brief Empty if the folder has none. Throws IoError. */
  static std::optional<Provenance> read(const std::filesystem::path& folder);
  void write(const std::filesystem::path& folder) const;
  /** \brief Throws UsageError if write() would replace an input file. */
  static void requireNotReplaced(const std::filesystem::path& input, const std::filesystem::path& folder);
  /** \brief Throws IoError, which names the folder, if results of these images, made as this says, would
   * come out differently now. Other images may have changed. */
  void requireSame(const Provenance& now, const std::vector<std::string>& done,
                   const std::string& folder) const;
};

/** \brief Throws UsageError if a folder of results is the folder of the images. */
void requireOtherFolder(const std::filesystem::path& results, const std::filesystem::path& images);

/** \brief Writes inputs.csv to a folder of results: the file, or the recording, that each frame is from.
 * Throws IoError. */
void writeInputs(const std::filesystem::path& folder, const std::vector<FrameFile>& frames);

}  // namespace facetloc
