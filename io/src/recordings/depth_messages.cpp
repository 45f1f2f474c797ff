// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/depth_messages.h"

#include <facetloc/io/error.h>

#include <cmath>
#include <cstring>
#include <fmt/format.h>

namespace facetloc::internal {
namespace {

constexpr const char* kFloat = "32FC1";
constexpr const char* kCompressedDepth = "compressedDepth";

bool has(const std::string& text, const char* word) { return text.find(word) != std::string::npos; }

/** Bytes of a pixel; 0 if it is no depth. */
std::size_t pixelSize(const std::string& encoding) {
  if (encoding == "16UC1" || encoding == "mono16") return sizeof(std::uint16_t);
  return encoding == kFloat ? sizeof(float) : 0;
}

float measured(float z) { return std::isfinite(z) && z > 0 ? z : 0; }

bool isPngData(ByteView bytes) {
  constexpr char kBegin[] = "\x89PNG";
  return bytes.size > 4 && std::memcmp(bytes.data, kBegin, 4) == 0;
}

/** Depth by the plain transport, unlike pictures of 8 bits or of colours. */
bool isGreyPngOf16Bits(ByteView bytes) {
  constexpr std::size_t kBits = 24, kColours = 25;  // places in the header
  return isPngData(bytes) && bytes.size > kColours && bytes.data[kBits] == 16 && bytes.data[kColours] == 0;
}

/** Reads RVL. */
class RvlDecoder {
public:
  explicit RvlDecoder(ByteView code) : code_(code) {}

  /** Stays short if the code is for fewer pixels. */
  std::vector<std::uint16_t> decode(std::size_t pixels) {
    std::vector<std::uint16_t> out;  // grows with the code, which may claim any size
    int value = 0;
    while (out.size() < pixels && !ended_) {
      const std::uint32_t zeros = number();
      if (zeros > pixels - out.size()) break;
      out.resize(out.size() + zeros);
      std::uint32_t others = number();
      if (others > pixels - out.size()) break;
      for (; others > 0 && !ended_; --others) {
        const std::uint32_t n = number();
        value += static_cast<int>(n >> 1) ^ -static_cast<int>(n & 1);
        value &= 0xFFFF;
        if (!ended_) out.push_back(static_cast<std::uint16_t>(value));
      }
    }
    return out;
  }

private:
  std::uint32_t nibble() {
    constexpr std::size_t kWord = 4;  // bytes
    const std::size_t byte = next_ / 2, place = byte - byte % kWord + (kWord - 1 - byte % kWord);
    if (place >= code_.size) {
      ended_ = true;
      return 0;
    }
    const bool high = next_++ % 2 == 0;
    return high ? code_.data[place] >> 4 : code_.data[place] & 0xF;
  }

  std::uint32_t number() {
    constexpr int kBits = 3, kMost = 30;
    std::uint32_t value = 0, n = 8;
    for (int shift = 0; (n & 8) != 0; shift += kBits) {
      n = nibble();
      if (shift >= kMost) ended_ = true;
      if (ended_) return 0;
      value |= (n & 7) << shift;
    }
    return value;
  }

  ByteView code_;
  std::size_t next_ = 0;  // nibble
  bool ended_ = false;
};

}  // namespace

bool isDepth(const ImageMessage& image) { return pixelSize(image.encoding) > 0; }

bool isDepth(const CompressedImageMessage& image) {
  return has(image.format, kCompressedDepth) || isGreyPngOf16Bits(image.data);
}

StoredDepth readDepth(const ImageMessage& image, const std::string& name) {
  constexpr std::uint32_t kLargestSide = 65535;
  const std::size_t pixel = pixelSize(image.encoding);
  if (pixel == 0)
    throw IoError(name, fmt::format("is of the encoding '{}'; {}", image.encoding, kDepthEncodings));
  const std::uint32_t width = image.width, height = image.height;
  if (width == 0 || height == 0 || width > kLargestSide || height > kLargestSide ||
      image.step < width * pixel || image.data.size < std::size_t(image.step) * height)
    throw IoError(name, "is corrupt");
  StoredDepth values{static_cast<int>(width), static_cast<int>(height), {}, {}};
  for (std::uint32_t v = 0; v < height; ++v)
    for (std::uint32_t u = 0; u < width; ++u) {
      const auto* bytes =
          reinterpret_cast<const char*>(image.data.data) + std::size_t(v) * image.step + u * pixel;
      if (pixel == sizeof(float))
        values.metres.push_back(measured(numberAt<float>(bytes, image.big_endian)));
      else
        values.numbers.push_back(numberAt<std::uint16_t>(bytes, image.big_endian));
    }
  return values;
}

StoredDepth readDepth(const CompressedImageMessage& image, const std::string& name) {
  if (!isDepth(image))
    throw IoError(name, fmt::format("is of the format '{}'; {}", image.format, kDepthEncodings));
  if (isPngData(image.data)) return readPngValues(image.data, name);  // some writers leave out the head
  constexpr std::size_t kHead = 12;
  if (image.data.size <= kHead) throw IoError(name, "is corrupt: it is too short for compressedDepth");
  MessageReader head(image.data, WireFormat::ros1);
  head.skip<std::uint32_t>(1);
  const auto a = head.number<float>(), b = head.number<float>();
  const ByteView code{image.data.data + kHead, image.data.size - kHead};
  StoredDepth values = has(image.format, "rvl") ? readRvl(code, name) : readPngValues(code, name);
  if (!has(image.format, kFloat)) return values;
  for (const std::uint16_t v : values.numbers)
    values.metres.push_back(v > 0 ? measured(a / (static_cast<float>(v) - b)) : 0.f);
  values.numbers.clear();
  return values;
}

StoredDepth readPngValues(ByteView bytes, const std::string& name) {
  constexpr int kBits = 16;
  return storedIn(readGreyPng(bytes.data, bytes.size, name, kBits));
}

DepthImage depthImageOf(StoredDepth values, double scale) {
  DepthImage image;
  image.camera.width = values.width, image.camera.height = values.height;
  image.depth = values.metres.empty() ? metresOf(values.numbers, scale) : std::move(values.metres);
  return image;
}

StoredDepth readRvl(ByteView bytes, const std::string& name) {
  constexpr std::size_t kHead = 8;
  if (bytes.size < kHead) throw IoError(name, "is a corrupt RVL image");
  MessageReader head(bytes, WireFormat::ros1);
  const std::uint64_t width = head.number<std::uint32_t>(), height = head.number<std::uint32_t>();
  if (width == 0 || height == 0 || width > kMostPixels || height > kMostPixels ||
      width * height > kMostPixels)
    throw IoError(name, fmt::format("is an RVL image that claims to be of {}x{} pixels", width, height));
  const std::size_t pixels = width * height;
  StoredDepth image{static_cast<int>(width), static_cast<int>(height), {}, {}};
  image.numbers = RvlDecoder({bytes.data + kHead, bytes.size - kHead}).decode(pixels);
  if (image.numbers.size() != pixels) throw IoError(name, "is a truncated or corrupt RVL image");
  return image;
}

}  // namespace facetloc::internal
