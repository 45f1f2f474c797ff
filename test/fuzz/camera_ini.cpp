// SPDX-License-Identifier: BSD-3-Clause
// Bytes as a camera.ini. One that is read is the same when it was written and read again.
#include "fuzz_file.h"

#include <facetloc/io/camera_file.h>
#include <facetloc/io/error.h>

#include <optional>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc;
  static const fuzz::Folder folder;
  const auto path = folder.put("camera.ini", fuzz::asText(data, size));
  std::optional<CameraFile> read;
  fuzz::accepts<IoError>([&] { read = readCameraFile(path); });
  if (!read) return 0;
  writeCameraFile(path, *read);
  const CameraFile again = readCameraFile(path);
  fuzz::require(again.camera.intrinsics == read->camera.intrinsics &&
                    again.depth_scale == read->depth_scale && again.lens == read->lens &&
                    again.depth_is == read->depth_is &&
                    again.camera.noise.inverse_depth_std == read->camera.noise.inverse_depth_std &&
                    again.camera.noise.depth_std == read->camera.noise.depth_std &&
                    again.camera.noise.depth_std_slope == read->camera.noise.depth_std_slope &&
                    again.camera.max_depth == read->camera.max_depth && again.preset == read->preset &&
                    again.camera.mounting.has_value() == read->camera.mounting.has_value(),
                "a camera differs from the one written");
  return 0;
}
