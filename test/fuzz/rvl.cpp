// SPDX-License-Identifier: BSD-3-Clause
// Bytes as an RVL image.
#include "fuzz_file.h"
#include "recordings/depth_messages.h"

#include <facetloc/io/error.h>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc;
  fuzz::accepts<IoError>([&] {
    const StoredDepth image = internal::readRvl({data, size}, "image");
    const auto n = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    fuzz::require(n > 0 && image.numbers.size() == n, "an image is not of its size");
  });
  return 0;
}
