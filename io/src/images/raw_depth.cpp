// SPDX-License-Identifier: BSD-3-Clause
// Formats whose pixels are not packed: NPY, PGM and PFM.
#include "base/text.h"
#include "bytes/files.h"
#include "images/depth_file.h"

#include <facetloc/io/atomic_file.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fmt/format.h>
#include <string>
#include <string_view>

namespace facetloc {
namespace {
std::string bytesOf(const fs::path& path) {
  std::string bytes = files::readBytes(path);
  if (bytes.empty()) throw IoError(path.string(), "is empty");
  return bytes;
}

float halfAt(const char* bytes, bool big_endian) {
  constexpr int kMantissa = 10, kBias = 15, kLargest = 31;
  const auto bits = numberAt<std::uint16_t>(bytes, big_endian);
  const int exponent = bits >> kMantissa & kLargest, mantissa = bits & ((1 << kMantissa) - 1);
  if (exponent == kLargest || bits >> 15) return 0;  // infinite, none, or negative
  if (exponent == 0) return std::ldexp(static_cast<float>(mantissa), 1 - kBias - kMantissa);
  return std::ldexp(static_cast<float>(mantissa | 1 << kMantissa), exponent - kBias - kMantissa);
}

/** The text behind a key of the header of an NPY file, without blanks. */
std::string_view behind(std::string_view header, std::string_view key) {
  const auto at = header.find(key);
  return at == std::string_view::npos ? std::string_view() : text::trimmed(header.substr(at + key.size()));
}

struct NpyHeader {
  bool big_endian = false;
  std::string type;  // "u2"
  std::uint64_t width = 0, height = 0;
  bool by_columns = false;
};

NpyHeader parseHeader(const fs::path& path, std::string_view header) {
  const auto fail = [&path](const std::string& cause) -> void { throw IoError(path.string(), cause); };
  NpyHeader parsed;
  const std::string_view type = behind(header, "'descr':"), order = behind(header, "'fortran_order':");
  if (type.size() < 5 || type[0] != '\'' || type[4] != '\'') fail("is not an NPY file of plain numbers");
  parsed.big_endian = type[1] == '>';
  parsed.type = type.substr(2, 2);
  parsed.by_columns = order.rfind("True", 0) == 0;
  std::string_view shape = behind(header, "'shape':");
  const auto end = shape.find(')');
  if (shape.empty() || shape[0] != '(' || end == std::string_view::npos)
    fail("is a corrupt NPY file: no shape");
  std::vector<std::uint64_t> sides;
  const std::string_view list = shape.substr(1, end - 1);
  for (const std::string_view side : text::split(list, ',')) {
    if (text::trimmed(side).empty()) continue;
    const auto value = text::to<std::uint64_t>(text::trimmed(side));
    if (!value) fail("is a corrupt NPY file: its shape is not of whole numbers");
    sides.push_back(*value);
  }
  if (sides.size() == 3 && sides[2] == 1) sides.pop_back();
  if (sides.size() == 3 && sides[0] == 1) sides.erase(sides.begin());
  if (sides.size() != 2)
    fail(fmt::format(
        "holds an array of the shape ({}), not one depth image of height x width: write each image "
        "to a file of its own",
        list));
  parsed.height = sides[0], parsed.width = sides[1];
  return parsed;
}

/** A number that fits; 0 = not measured. */
std::uint16_t asNumber(std::int64_t value) {
  return value > 0 && value <= 65535 ? static_cast<std::uint16_t>(value) : 0;
}

/** The words of a header, which become numbers; # starts a comment. */
class NetpbmHeader {
public:
  /** \param source named in errors; like the bytes, it must outlive the header */
  NetpbmHeader(const std::string& source, std::string_view bytes) : source_(source), bytes_(bytes) {}

  std::string_view word() {
    const auto isBlank = [](char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; };
    while (at_ < bytes_.size() && (isBlank(bytes_[at_]) || bytes_[at_] == '#'))
      if (bytes_[at_++] == '#')
        while (at_ < bytes_.size() && bytes_[at_] != '\n') ++at_;
    const std::size_t begin = at_;
    while (at_ < bytes_.size() && !isBlank(bytes_[at_])) ++at_;
    if (begin == at_) throw IoError(source_, "is truncated");
    return bytes_.substr(begin, at_ - begin);
  }
  template <typename Number>
  Number number() {
    const auto value = text::to<Number>(word());
    if (!value) throw IoError(source_, "has a corrupt header");
    return *value;
  }
  /** Behind one blank. */
  std::string_view pixels() const { return bytes_.substr(std::min(at_ + 1, bytes_.size())); }

private:
  const std::string& source_;
  std::string_view bytes_;
  std::size_t at_ = 0;
};

/** Throws IoError for fewer bytes than an image needs. */
void requireBytes(const std::string& source, std::size_t there, std::uint64_t needed) {
  if (there < needed)
    throw IoError(source, fmt::format("is truncated: {} bytes of pixels instead of {}", there, needed));
}

void readBinary(std::string_view bytes, bool wide, std::vector<std::uint16_t>& values) {
  const auto byte = [&bytes](std::size_t i) { return static_cast<std::uint8_t>(bytes[i]); };
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = wide ? static_cast<std::uint16_t>(byte(2 * i) << 8 | byte(2 * i + 1)) : byte(i);
}

}  // namespace

void requireSize(const std::string& source, std::uint64_t width, std::uint64_t height) {
  if (width == 0 || height == 0 || width > kMostPixels || height > kMostPixels ||
      width * height > kMostPixels)
    throw IoError(source, fmt::format("claims to be of {}x{} pixels", width, height));
}

Greymap parsePgm(const std::string& source, std::string_view bytes) {
  constexpr std::uint32_t kNarrow = 255, kWide = 65535;
  NetpbmHeader header(source, bytes);
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

void writePgm(const fs::path& path, const Raster<std::uint8_t>& image) {
  writeTextAtomically(path, [&image](std::ostream& out) {
    out << "P5\n" << image.width << " " << image.height << "\n255\n";
    out.write(reinterpret_cast<const char*>(image.data.data()),
              static_cast<std::streamsize>(image.data.size()));
  });
}

StoredDepth readNpy(const fs::path& path) {
  constexpr std::size_t kMagic = 6, kShort = 10, kLong = 12;
  const std::string bytes = bytesOf(path);
  if (bytes.size() < kLong || bytes.compare(0, kMagic, "\x93NUMPY") != 0)
    throw IoError(path.string(), "is not an NPY file");
  const bool is_short = bytes[kMagic] == 1;
  const std::size_t begin = is_short ? kShort : kLong;
  const std::size_t length = is_short ? numberAt<std::uint16_t>(bytes.data() + 8, false)
                                      : numberAt<std::uint32_t>(bytes.data() + 8, false);
  requireBytes(path.string(), bytes.size(), begin + length);
  const NpyHeader header = parseHeader(path, std::string_view(bytes).substr(begin, length));
  requireSize(path.string(), header.width, header.height);
  const std::size_t n = header.width * header.height, size = static_cast<std::size_t>(header.type[1] - '0');
  const char* data = bytes.data() + begin + length;
  constexpr std::size_t kLargest = 8;
  requireBytes(path.string(), bytes.size() - begin - length, n * std::min(size, kLargest));

  StoredDepth values{static_cast<int>(header.width), static_cast<int>(header.height), {}, {}};
  const auto fill = [&](auto& out, auto valueAt) {
    out.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t at = header.by_columns ? i / header.width + i % header.width * header.height : i;
      out[i] = valueAt(data + at * size);
    }
  };
  const bool big = header.big_endian;
  const std::string& type = header.type;
  if (type == "u2")
    fill(values.numbers, [big](const char* p) { return numberAt<std::uint16_t>(p, big); });
  else if (type == "i2")
    fill(values.numbers, [big](const char* p) { return asNumber(numberAt<std::int16_t>(p, big)); });
  else if (type == "u4")
    fill(values.numbers, [big](const char* p) { return asNumber(numberAt<std::uint32_t>(p, big)); });
  else if (type == "i4")
    fill(values.numbers, [big](const char* p) { return asNumber(numberAt<std::int32_t>(p, big)); });
  else if (type == "f2")
    fill(values.metres, [big](const char* p) { return halfAt(p, big); });
  else if (type == "f4")
    fill(values.metres, [big](const char* p) { return numberAt<float>(p, big); });
  else if (type == "f8")
    fill(values.metres, [big](const char* p) { return static_cast<float>(numberAt<double>(p, big)); });
  else
    throw IoError(path.string(), "is of the type " + text::quoted(type) +
                                     ", not of one of u2, i2, u4, i4 (by depth_scale), f2, f4, f8 (metres)");
  return values;
}

StoredDepth readPgm(const fs::path& path) {
  constexpr int kNarrow = 255;  // largest value of 8 bits
  Greymap map = parsePgm(path.string(), bytesOf(path));
  if (map.white <= kNarrow) throw IoError(path.string(), "has 8 bits per pixel, not 16");
  return storedIn(std::move(map.image));
}

StoredDepth readPfm(const fs::path& path) {
  const std::string bytes = bytesOf(path), source = path.string();
  NetpbmHeader header(source, bytes);
  if (header.word() != "Pf") throw IoError(path.string(), "is not a PFM file of one channel");
  const auto width = header.number<std::uint32_t>(), height = header.number<std::uint32_t>();
  const bool big_endian = header.number<double>() > 0;
  requireSize(path.string(), width, height);
  const std::size_t n = std::size_t(width) * height;
  const std::string_view pixels = header.pixels();
  requireBytes(path.string(), pixels.size(), sizeof(float) * n);
  StoredDepth values{static_cast<int>(width), static_cast<int>(height), std::vector<float>(n), {}};
  for (std::size_t v = 0; v < height; ++v)
    for (std::size_t u = 0; u < width; ++u)
      values.metres[v * width + u] =
          numberAt<float>(pixels.data() + sizeof(float) * ((height - 1 - v) * width + u), big_endian);
  return values;
}

}  // namespace facetloc
