// SPDX-License-Identifier: BSD-3-Clause
#include "frame_source.h"

#include "scene_source.h"
#include "sequence_source.h"

#include <filesystem>

namespace facetloc {

bool isFrameSource(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::is_directory(path, ignored) || std::filesystem::path(path).extension() == ".scene";
}

std::unique_ptr<FrameSource> openFrameSource(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return std::make_unique<SequenceSource>(path);
  return std::make_unique<SceneSource>(readSceneFile(path));
}

}  // namespace facetloc
