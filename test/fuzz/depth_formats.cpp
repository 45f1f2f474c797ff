// SPDX-License-Identifier: BSD-3-Clause
// A letter that names a format, and bytes as a depth image of it.
#include "fuzz_file.h"
#include "images/depth_file.h"

#include <facetloc/io/error.h>

#include <cmath>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc;
  static const fuzz::Folder folder;
  const auto input = fuzz::asText(data, size);
  if (input.empty()) return 0;
  const char* name = input[0] == 't'   ? "0.tif"
                     : input[0] == 'n' ? "0.npy"
                     : input[0] == 'g' ? "0.pgm"
                                       : "0.pfm";
  const auto path = folder.put(name, input.substr(1));
  fuzz::accepts<IoError>([&] {
    const StoredDepth values = readDepthValues(path);
    const auto n = static_cast<std::size_t>(values.width) * static_cast<std::size_t>(values.height);
    fuzz::require(n > 0 && values.metres.size() + values.numbers.size() == n, "an image is not of its size");
    for (const float z : values.metres) fuzz::require(std::isfinite(z) && z >= 0, "a depth is not finite");
  });
  return 0;
}
