// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/rvl.h"

#include <facetloc/io/error.h>

#include <fmt/format.h>

namespace facetloc::internal {
namespace {

class Decoder {
public:
  explicit Decoder(ByteView code) : code_(code) {}

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
  image.numbers = Decoder({bytes.data + kHead, bytes.size - kHead}).decode(pixels);
  if (image.numbers.size() != pixels) throw IoError(name, "is a truncated or corrupt RVL image");
  return image;
}

}  // namespace facetloc::internal
