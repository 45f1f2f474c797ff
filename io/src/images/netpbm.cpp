// SPDX-License-Identifier: BSD-3-Clause
#include "images/netpbm.h"

#include "images/depth_file.h"

#include <facetloc/io/atomic_file.h>

#include <algorithm>
#include <cctype>
#include <fmt/core.h>

namespace facetloc::netpbm {
namespace {

void readBinary(std::string_view bytes, bool wide, std::vector<std::uint16_t>& values) {
  const auto byte = [&bytes](std::size_t i) { return static_cast<std::uint8_t>(bytes[i]); };
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = wide ? static_cast<std::uint16_t>(byte(2 * i) << 8 | byte(2 * i + 1)) : byte(i);
}

}  // namespace

std::string_view Header::word() {
  const auto isBlank = [](char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; };
  while (at_ < bytes_.size() && (isBlank(bytes_[at_]) || bytes_[at_] == '#'))
    if (bytes_[at_++] == '#')
      while (at_ < bytes_.size() && bytes_[at_] != '\n') ++at_;
  const std::size_t begin = at_;
  while (at_ < bytes_.size() && !isBlank(bytes_[at_])) ++at_;
  if (begin == at_) throw IoError(source_, "is truncated");
  return bytes_.substr(begin, at_ - begin);
}

std::string_view Header::pixels() const { return bytes_.substr(std::min(at_ + 1, bytes_.size())); }

void requireSize(const std::string& source, std::uint64_t width, std::uint64_t height) {
  if (width == 0 || height == 0 || width > kMostPixels || height > kMostPixels ||
      width * height > kMostPixels)
    throw IoError(source, fmt::format("claims to be of {}x{} pixels", width, height));
}

void requireBytes(const std::string& source, std::size_t there, std::uint64_t needed) {
  if (there < needed)
    throw IoError(source, fmt::format("is truncated: {} bytes of pixels instead of {}", there, needed));
}

Greymap parsePgm(const std::string& source, std::string_view bytes) {
  constexpr std::uint32_t kNarrow = 255, kWide = 65535;
  Header header(source, bytes);
  const std::string_view kind = header.word();
  if (kind != "P5" && kind != "P2") throw IoError(source, "is not a PGM file");
  const auto width = header.number<std::uint32_t>(), height = header.number<std::uint32_t>();
  const auto white = header.number<std::uint32_t>();
  requireSize(source, width, height);
  if (white < 1 || white > kWide) throw IoError(source, fmt::format("has a largest value of {}", white));
  const std::size_t n = std::size_t(width) * height;
  const std::string_view pixels = header.pixels();
  // A decimal number takes two bytes with its blank, but for the last one.
  requireBytes(source, pixels.size(), kind == "P2" ? 2 * n - 1 : white > kNarrow ? 2 * n : n);
  Greymap map;
  map.white = static_cast<int>(white);
  map.image.width = static_cast<int>(width), map.image.height = static_cast<int>(height);
  map.image.data.resize(n);
  if (kind == "P5") return readBinary(pixels, white > kNarrow, map.image.data), map;
  for (std::uint16_t& value : map.image.data) {
    const auto number = header.number<std::uint32_t>();
    if (number > white)
      throw IoError(source, fmt::format("has a pixel of {}, which is more than white", number));
    value = static_cast<std::uint16_t>(number);
  }
  return map;
}

void writePgm(const std::filesystem::path& path, const Raster<std::uint8_t>& image) {
  writeTextAtomically(path, [&image](std::ostream& out) {
    out << "P5\n" << image.width << " " << image.height << "\n255\n";
    out.write(reinterpret_cast<const char*>(image.data.data()),
              static_cast<std::streamsize>(image.data.size()));
  });
}

}  // namespace facetloc::netpbm
