// SPDX-License-Identifier: BSD-3-Clause
// Bytes as a PNG.
#include "fuzz_file.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/error.h>
#include <facetloc/io/png.h>

#include <algorithm>
#include <libdeflate.h>

namespace {

constexpr std::size_t kSignature = 8, kNumber = 4;

std::uint32_t numberAt(const std::uint8_t* bytes) {  // big-endian
  return std::uint32_t(bytes[0]) << 24 | bytes[1] << 16 | bytes[2] << 8 | bytes[3];
}

/** A chunk is its length, its type and data, and the checksum of both, which libpng sees to before anything
 * else. */
void repairChecksums(std::uint8_t* data, std::size_t size) {
  for (std::size_t at = kSignature; at + 3 * kNumber <= size;) {
    const std::size_t length = std::min<std::size_t>(numberAt(data + at), size - at - 3 * kNumber);
    const std::uint32_t sum = libdeflate_crc32(0, data + at + kNumber, kNumber + length);
    at += 2 * kNumber + length;
    for (int shift = 24; shift >= 0; shift -= 8) data[at++] = static_cast<std::uint8_t>(sum >> shift);
  }
}

}  // namespace

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most,
                                               unsigned seed) {
  size = LLVMFuzzerMutate(data, size, most);
  constexpr unsigned kLeftTorn = 16;  // one of 16
  if (seed % kLeftTorn) repairChecksums(data, size);
  return size;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t bytes) {
  using namespace facetloc;
  static const fuzz::Folder folder;
  const auto path = folder.put("0.png", fuzz::asText(data, bytes));
  const auto size = pngSize(path);
  fuzz::accepts<IoError>([&] {
    const auto image = readGreyPng(path);
    CameraFile file;
    Intrinsics& camera = file.camera.intrinsics;
    camera.width = image.width, camera.height = image.height;
    fuzz::require(size && (size->bits == 8 || size->bits == 16), "a PNG of other bits is read");
    if (size->bits == 16) readDepthPng(path, file);
  });
  return 0;
}
