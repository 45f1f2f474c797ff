// SPDX-License-Identifier: BSD-3-Clause
// A letter that names a cell of a database of RTAB-Map, and bytes as its content.
#include "fuzz_file.h"
#include "recordings/depth_messages.h"

#include <facetloc/io/error.h>

#include <cmath>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc;
  using namespace facetloc::internal;
  if (size == 0) return 0;
  const ByteView cell{data + 1, size - 1};
  fuzz::accepts<IoError>([&] {
    if (data[0] == 'c') fuzz::require(readRtabmapCamera(cell, "").intrinsics.valid(), "a camera is invalid");
    if (data[0] == 'p') readRtabmapPose(cell, "");
    if (data[0] == 'g')
      readRtabmapGraph({cell.data, cell.size / 2}, {cell.data + cell.size / 2, cell.size / 2}, "");
    if (data[0] != 'd') return;
    for (const float z : readRtabmapDepth(cell, "").metres)
      fuzz::require(std::isfinite(z) && z >= 0, "a depth is not finite");
  });
  return 0;
}
