// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <libdeflate.h>
#include <memory>
#include <new>
#include <optional>
#include <vector>

/** \file
 * Lossless packing of the small depth pictures in a map file, private to io. */

namespace facetloc::depth_blob {

/** \brief Each value less its left neighbour (0 before the first of a row), modulo 2^16, as 16 bits
 * little-endian, in a zlib stream. Neighbours are similar, so that the differences pack well. */
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
  constexpr int kLevel = 6;
  const std::unique_ptr<libdeflate_compressor, void (*)(libdeflate_compressor*)> compressor(
      libdeflate_alloc_compressor(kLevel), libdeflate_free_compressor);
  if (!compressor) throw std::bad_alloc();
  std::vector<std::uint8_t> packed(libdeflate_zlib_compress_bound(compressor.get(), bytes.size()));
  packed.resize(
      libdeflate_zlib_compress(compressor.get(), bytes.data(), bytes.size(), packed.data(), packed.size()));
  return packed;
}

/** \brief Unpacks a zlib stream. \return is it sound, and exactly of that many bytes? */
inline bool unpack(const std::uint8_t* packed, std::size_t packed_size, void* bytes, std::size_t size) {
  const std::unique_ptr<libdeflate_decompressor, void (*)(libdeflate_decompressor*)> decompressor(
      libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
  if (!decompressor) throw std::bad_alloc();
  // Without a place for the size it insists on filling all of the buffer.
  return libdeflate_zlib_decompress(decompressor.get(), packed, packed_size, bytes, size, nullptr) ==
         LIBDEFLATE_SUCCESS;
}

/** \brief Empty unless the blob is sound and holds exactly width x height values. */
inline std::optional<std::vector<std::uint16_t>> decode(const std::vector<std::uint8_t>& packed, int width,
                                                        int height) {
  const std::size_t count = std::size_t(width) * height;
  const std::unique_ptr<std::uint8_t[]> bytes(new std::uint8_t[2 * count]);
  if (!unpack(packed.data(), packed.size(), bytes.get(), 2 * count)) return {};
  std::vector<std::uint16_t> values(count);
  const std::uint8_t* from = bytes.get();
  std::uint16_t* to = values.data();
  for (int v = 0; v < height; ++v) {
    std::uint16_t left = 0;
    for (int u = 0; u < width; ++u, from += 2)
      *to++ = left = static_cast<std::uint16_t>(left + (from[0] | from[1] << 8));
  }
  return values;
}

}  // namespace facetloc::depth_blob
