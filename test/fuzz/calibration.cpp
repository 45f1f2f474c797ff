// SPDX-License-Identifier: BSD-3-Clause
// Bytes as a calibration in YAML or JSON. The lens of one that is read leaves finite images.
#include "fuzz_file.h"
#include "recordings/recording_layout.h"

#include <facetloc/io/error.h>

#include <cmath>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc;
  std::optional<internal::Calibration> read;
  if (!fuzz::accepts<IoError>(
          [&] { read = internal::parseCalibration(fuzz::asText(data, size), "c.yaml"); }) ||
      !read)
    return 0;
  Intrinsics camera = read->intrinsics;
  camera.width = 8, camera.height = 6;
  if (!camera.valid()) return 0;
  for (const DepthKind kind : {DepthKind::z, DepthKind::distance})
    for (const float z :
         LensCorrection(camera, read->lens, kind)({camera, std::vector<float>(48, 1.f)}).depth)
      fuzz::require(std::isfinite(z) && z >= 0, "a depth is not finite");
  return 0;
}
