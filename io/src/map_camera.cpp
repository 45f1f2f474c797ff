// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/io/error.h>
#include <facetloc/io/map_camera.h>
#include <facetloc/io/map_database.h>

#include <array>
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

}  // namespace facetloc
