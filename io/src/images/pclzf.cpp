// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "bytes/files.h"
#include "bytes/lzf.h"

#include <facetloc/io/pclzf.h>

#include <boost/property_tree/ptree.hpp>
#include <boost/property_tree/xml_parser.hpp>

#include <cstring>
#include <fmt/format.h>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace facetloc {
namespace {

constexpr std::size_t kHeader = 37;
constexpr std::uint32_t kDepthBytes = 2;

struct Header {
  std::uint32_t width = 0, height = 0, packed = 0, unpacked = 0;
};

/** "PCLZF", width, height, 16 characters of type, packed size, unpacked size; numbers in 4 bytes,
 * little-endian. */
Header readHeader(const fs::path& file, std::string_view bytes) {
  constexpr std::size_t kPlaces[] = {5, 9, 29, 33};  // where numbers are
  constexpr std::uint32_t kLargestSide = 4096;
  constexpr std::uint32_t kMostPacked = 88;  // LZF unpacks 3 bytes to 264 at most
  if (bytes.size() < kHeader) throw IoError(file.string(), "is truncated");
  Header h;
  std::uint32_t* to[] = {&h.width, &h.height, &h.packed, &h.unpacked};
  for (std::size_t i = 0; i < 4; ++i) std::memcpy(to[i], bytes.data() + kPlaces[i], sizeof *to[i]);
  if (bytes.substr(0, 5) != "PCLZF") throw IoError(file.string(), "is no PCLZF file");
  if (bytes.substr(13, 7) != "depth16") throw IoError(file.string(), "is no 16-bit depth image");
  if (h.width == 0 || h.height == 0 || h.width > kLargestSide || h.height > kLargestSide)
    throw IoError(file.string(), fmt::format("its size of {}x{} pixels is impossible", h.width, h.height));
  if (h.unpacked != kDepthBytes * h.width * h.height)
    throw IoError(file.string(), "its sizes in pixels and in bytes do not fit each other");
  if (h.unpacked > std::uint64_t(kMostPacked) * h.packed)
    throw IoError(file.string(), "its packed size does not fit its size in pixels");
  return h;
}

/** Nothing if there is no such number. */
std::optional<double> numberOf(const boost::property_tree::ptree& depth, const char* key) {
  const auto words = depth.get_optional<std::string>(key);
  return words ? text::to<double>(text::trimmed(*words)) : std::nullopt;
}

/** The part of a camera's file that is about depth. */
boost::property_tree::ptree readDepthCamera(const fs::path& path) {
  boost::property_tree::ptree camera;
  std::istringstream in(files::readText(path));
  try {
    boost::property_tree::read_xml(in, camera);
    return camera.get_child("depth");
  } catch (const boost::property_tree::ptree_error&) {
    throw IoError(path.string(), "no camera parameters can be read");
  }
}

}  // namespace

Raster<std::uint16_t> readPclzf(const fs::path& path) {
  files::requireRegularFile(path);
  const std::string file = files::readBytes(path);
  const Header header = readHeader(path, file);
  const std::string_view packed = std::string_view(file).substr(kHeader, header.packed);
  if (packed.size() < header.packed)
    throw IoError(path.string(),
                  fmt::format("is truncated: {} packed bytes instead of {}", packed.size(), header.packed));
  std::vector<std::uint8_t> bytes(header.unpacked);
  if (!lzfUnpack(packed, bytes)) throw IoError(path.string(), "is corrupt: it cannot be unpacked");
  Raster<std::uint16_t> image{static_cast<int>(header.width), static_cast<int>(header.height), 1, {}};
  image.data.resize(std::size_t(header.width) * header.height);
  std::memcpy(image.data.data(), bytes.data(), bytes.size());  // both little-endian
  return image;
}

PclzfCamera readPclzfCamera(const fs::path& path, int width, int height) {
  files::requireRegularFile(path);
  const boost::property_tree::ptree depth = readDepthCamera(path);
  const auto fx = numberOf(depth, "focal_length_x"), fy = numberOf(depth, "focal_length_y"),
             cx = numberOf(depth, "principal_point_x"), cy = numberOf(depth, "principal_point_y"),
             factor = numberOf(depth, "z_multiplication_factor");  // metres per value
  if (!fx || !fy || !cx || !cy || !factor) throw IoError(path.string(), "no camera parameters can be read");
  PclzfCamera camera;
  camera.intrinsics = {width, height, *fx, *fy, *cx, *cy};
  if (*factor > 0 && *factor <= 1) camera.depth_scale = 1 / *factor;
  if (!camera.intrinsics.valid()) throw IoError(path.string(), "its camera is impossible");
  return camera;
}

}  // namespace facetloc
