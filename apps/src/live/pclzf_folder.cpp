// SPDX-License-Identifier: BSD-3-Clause
#include "live/pclzf_folder.h"

#include <facetloc/io/error.h>

#include <pcl/io/lzf_image_io.h>

#include <array>
#include <cctype>
#include <cstdint>
#include <exception>
#include <fmt/format.h>
#include <fstream>
#include <string>
#include <string_view>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExtension = ".pclzf";

bool isDepth(const fs::path& file) {
  return file.extension() == kExtension && file.filename().string().find("depth") != std::string::npos;
}

/** frame_20121214T142255.814212_depth.pclzf; digits where the pattern has a 0. */
void requireTime(const fs::path& file) {
  constexpr std::string_view kPattern = "frame_00000000T000000.000000_";
  const std::string name = file.filename().string();
  bool fits = name.size() >= kPattern.size();
  for (std::size_t i = 0; fits && i < kPattern.size(); ++i)
    fits =
        kPattern[i] == '0' ? std::isdigit(static_cast<unsigned char>(name[i])) != 0 : name[i] == kPattern[i];
  if (!fits)
    throw IoError(
        file.string(),
        "its name tells no time as PCL's recorder writes it, frame_20121214T142255.814212_depth.pclzf");
}

/** "PCLZF", width, height, 16 characters of type, packed size, unpacked size; numbers in 4 bytes,
 * little-endian. */
void requireHeader(const fs::path& file) {
  constexpr std::size_t kHeader = 37, kNumbers[] = {5, 9, 29, 33};
  constexpr std::uint32_t kLargestSide = 4096, kDepthBytes = 2;
  constexpr std::uint32_t kMostPacked = 88;  // LZF unpacks 3 bytes to 264 at most
  std::array<char, kHeader> header{};
  std::ifstream in(file, std::ios::binary);
  if (!in.read(header.data(), header.size())) throw IoError(file.string(), "is truncated");
  std::uint32_t numbers[4] = {};
  for (int i = 0; i < 4; ++i)
    for (int k = 3; k >= 0; --k)
      numbers[i] =
          numbers[i] << 8 | static_cast<std::uint8_t>(header[kNumbers[i] + static_cast<std::size_t>(k)]);
  const std::uint32_t width = numbers[0], height = numbers[1], packed = numbers[2], unpacked = numbers[3];
  if (std::string_view(header.data(), 5) != "PCLZF") throw IoError(file.string(), "is no PCLZF file");
  if (std::string_view(header.data() + 13, 7) != "depth16")
    throw IoError(file.string(), "is no 16-bit depth image");
  if (width == 0 || height == 0 || width > kLargestSide || height > kLargestSide)
    throw IoError(file.string(), fmt::format("its size of {}x{} pixels is impossible", width, height));
  if (unpacked != kDepthBytes * width * height)
    throw IoError(file.string(), "its sizes in pixels and in bytes do not fit each other");
  if (unpacked > std::uint64_t(kMostPacked) * packed)
    throw IoError(file.string(), "its packed size does not fit its size in pixels");
}

void requireCamera(const fs::path& file) {
  bool read = false;
  try {
    read = pcl::io::LZFDepth16ImageReader().readParameters(file.string());
  } catch (const std::exception&) {  // of the parser
  }
  if (!read) throw IoError(file.string(), "no camera parameters can be read");
}

}  // namespace

bool isPclzfFolder(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) return false;
  for (const auto& entry : fs::directory_iterator(path, ignored))
    if (entry.path().extension() == kExtension) return true;
  return false;
}

void requireSoundPclzf(const fs::path& folder) {
  std::size_t images = 0, cameras = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const fs::path& file = entry.path();
    if (isDepth(file)) {
      requireTime(file);
      requireHeader(file);
      ++images;
    } else if (file.extension() == ".xml") {
      requireTime(file.parent_path() / (file.stem().string() + "_"));
      requireCamera(file);
      ++cameras;
    }
  }
  if (cameras < images)
    throw IoError(folder.string(), fmt::format("has {} depth images, but only {} .xml files of their camera",
                                               images, cameras));
}

}  // namespace facetloc
