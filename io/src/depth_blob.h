// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <vector>
#include <zlib.h>

/** \file Lossless packing of the small depth pictures in a map file, private to io. */

namespace facetloc::depth_blob {

/** \brief Each value less its left neighbour (0 before the first of a row), modulo 2^16, as 16 bits
 * little-endian, deflated by zlib. Neighbours are alike, so that the differences pack well. */
inline constexpr const char* kEncoding = "u16le-left-difference-zlib";

inline std::vector<std::uint8_t> encode(const std::vector<std::uint16_t>& values, int width) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(2 * values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::uint16_t left = i % width ? values[i - 1] : 0;
    const auto difference = static_cast<std::uint16_t>(values[i] - left);
    bytes.push_back(static_cast<std::uint8_t>(difference & 0xFF));
    bytes.push_back(static_cast<std::uint8_t>(difference >> 8));
  }
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::vector<std::uint8_t> packed(size);
  if (compress(packed.data(), &size, bytes.data(), static_cast<uLong>(bytes.size())) != Z_OK)
    throw std::runtime_error("zlib is out of memory");
  packed.resize(size);
  return packed;
}

/** \brief Empty unless the blob is sound and holds exactly width x height values. */
inline std::optional<std::vector<std::uint16_t>> decode(const std::vector<std::uint8_t>& packed, int width,
                                                        int height) {
  const std::size_t count = std::size_t(width) * height;
  std::vector<std::uint8_t> bytes(2 * count);
  auto size = static_cast<uLongf>(bytes.size());
  const int status = uncompress(bytes.data(), &size, packed.data(), static_cast<uLong>(packed.size()));
  if (status != Z_OK || size != bytes.size()) return {};
  std::vector<std::uint16_t> values(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint16_t left = i % width ? values[i - 1] : 0;
    values[i] = static_cast<std::uint16_t>(left + (bytes[2 * i] | bytes[2 * i + 1] << 8));
  }
  return values;
}

}  // namespace facetloc::depth_blob
