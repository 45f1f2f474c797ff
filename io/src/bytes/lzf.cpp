// SPDX-License-Identifier: BSD-3-Clause
// A control byte below 32 is followed by that many bytes and one more, as they are. In others the upper three
// bits are the length of a repetition less 2 (7: the next byte is added), the lower five and the next byte
// its distance less 1.
#include "bytes/lzf.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

namespace facetloc {
namespace {

constexpr std::size_t kMostLiterals = 32, kLongest = 264, kFarthest = 8192;
constexpr std::size_t kShortest = 3;  // repetition that is worth two bytes
constexpr std::uint32_t kHashBits = 14;
constexpr std::size_t kInByte = 7;  // lengths from here on take a byte of their own

std::uint32_t hashOf(const char* at) {
  std::uint32_t three = 0;
  std::memcpy(&three, at, kShortest);
  return three * 2654435761u >> (32 - kHashBits);  // Knuth's multiplicative hashing
}

void putLiterals(std::string_view bytes, std::string& out) {
  while (!bytes.empty()) {
    const std::size_t n = std::min(bytes.size(), kMostLiterals);
    out += static_cast<char>(n - 1);
    out += bytes.substr(0, n);
    bytes.remove_prefix(n);
  }
}

void putRepetition(std::size_t distance, std::size_t length, std::string& out) {
  const std::size_t less = length - 2, back = distance - 1;
  out += static_cast<char>(std::min(less, kInByte) << 5 | back >> 8);
  if (less >= kInByte) out += static_cast<char>(less - kInByte);
  out += static_cast<char>(back & 0xFF);
}

std::size_t equalBytes(std::string_view bytes, std::size_t a, std::size_t b) {
  const std::size_t most = std::min(kLongest, bytes.size() - b);
  std::size_t n = 0;
  while (n < most && bytes[a + n] == bytes[b + n]) ++n;
  return n;
}

}  // namespace

std::string lzfPacked(std::string_view bytes) {
  std::string out;
  out.reserve(bytes.size() / 2);
  std::vector<std::size_t> latest(std::size_t(1) << kHashBits, bytes.size());  // where a hash was seen
  std::size_t literals = 0;                                                    // where those not put begin
  for (std::size_t at = 0; at + kShortest <= bytes.size();) {
    std::size_t& before = latest[hashOf(bytes.data() + at)];
    const std::size_t candidate = before;
    before = at;
    const bool near = candidate < at && at - candidate <= kFarthest;
    const std::size_t length = near ? equalBytes(bytes, candidate, at) : 0;
    if (length < kShortest) {
      ++at;
      continue;
    }
    putLiterals(bytes.substr(literals, at - literals), out);
    putRepetition(at - candidate, length, out);
    at += length;
    literals = at;
  }
  putLiterals(bytes.substr(literals), out);
  return out;
}

bool lzfUnpack(std::string_view packed, std::vector<std::uint8_t>& bytes) {
  std::size_t in = 0, out = 0;
  const auto next = [&] { return static_cast<std::uint8_t>(packed[in++]); };
  while (in < packed.size()) {
    const std::size_t control = next();
    if (control < kMostLiterals) {
      const std::size_t n = control + 1;
      if (packed.size() - in < n || bytes.size() - out < n) return false;
      std::memcpy(bytes.data() + out, packed.data() + in, n);
      in += n, out += n;
      continue;
    }
    std::size_t length = (control >> 5) + 2;
    if (packed.size() - in < (control >> 5 == kInByte ? 2u : 1u)) return false;
    if (control >> 5 == kInByte) length += next();
    const std::size_t distance = ((control & 0x1F) << 8 | next()) + 1;
    if (distance > out || bytes.size() - out < length) return false;
    for (; length > 0; --length, ++out) bytes[out] = bytes[out - distance];  // which may overlap
  }
  return out == bytes.size();
}

}  // namespace facetloc
