// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/camera_presets.h>
#include <facetloc/io/camera_file.h>
#include <facetloc/io/error.h>
#include <facetloc/io/map_database.h>

#include <array>
#include <fmt/core.h>
#include <fstream>
#include <string_view>

namespace facetloc {

bool isMapFile(const std::filesystem::path& path) {
  constexpr std::string_view kMagic = "SQLite format 3";
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return false;
  std::array<char, kMagic.size()> head{};
  std::ifstream in(path, std::ios::binary);
  return in.read(head.data(), head.size()) && std::string_view(head.data(), head.size()) == kMagic;
}

CameraFile cameraOfMap(const std::filesystem::path& map, const std::optional<CameraFile>& stored) {
  CameraFile file = stored.value_or(CameraFile{});
  const Intrinsics own = file.camera.intrinsics;
  file.camera = openMap(map).camera;
  file.camera.distortion.reset();
  file.preset.clear();
  if (!file.camera.intrinsics.valid()) file.camera.intrinsics = own;
  if (!file.camera.intrinsics.valid())
    throw IoError(map.string(),
                  "does not say the intrinsics of its camera, as each of its images has its own; give a "
                  "camera.ini");
  return file;
}

Camera cameraNamed(const std::string& file_or_name) {
  std::error_code ignored;
  if (isMapFile(file_or_name)) return cameraOfMap(file_or_name).camera;
  if (std::filesystem::exists(file_or_name, ignored)) return readCameraFile(file_or_name).camera;
  const CameraPreset* preset = findCameraPreset(file_or_name);
  if (!preset)
    throw IoError(file_or_name, fmt::format("is neither the file of a camera nor the name of one (known: {})",
                                            cameraPresetNames()));
  Camera camera = preset->camera();
  camera.intrinsics = preset->intrinsics();
  return camera;
}

}  // namespace facetloc
