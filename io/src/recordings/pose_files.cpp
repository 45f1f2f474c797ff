// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/pose_files.h"

#include "recordings/image_list.h"
#include "recordings/pose_table.h"

#include <facetloc/io/error.h>

#include <algorithm>
#include <cctype>
#include <string>
#include <system_error>
#include <utility>

namespace facetloc::internal {
namespace {

namespace fs = std::filesystem;

constexpr int kNoPoses = 9;

/** The less, the likelier are they the poses of the images. */
int rankOf(const fs::path& file) {
  const std::string extension = lowerExtension(file);
  if (extension != ".txt" && extension != ".csv" && extension != ".log" && extension != ".tum")
    return kNoPoses;
  std::string name = file.stem().string();
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const auto has = [&name](const char* word) { return name.find(word) != std::string::npos; };
  if (has("groundtruth") || has("ground_truth") || name == "gt" || endsWith(name, "_gt")) return 0;
  if (has("robot") || has("keyframe")) return kNoPoses;
  if (has("camera_pose") || has("cameratrajectory") || has("camera_trajectory")) return 1;
  if (has("pose")) return 2;
  if (has("traj")) return 3;
  return name == "odometry" && extension == ".csv" ? 4 : kNoPoses;
}

bool hasPoses(const fs::path& file) {
  try {
    return !readPoseTable(file).rows.empty();
  } catch (const IoError&) {
    return false;
  }
}

}  // namespace

std::optional<fs::path> trajectoryIn(const std::vector<fs::path>& folders) {
  for (const fs::path& folder : folders) {
    std::vector<std::pair<int, fs::path>> found;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder, ignored))
      if (const int rank = rankOf(entry.path()); rank < kNoPoses && entry.is_regular_file(ignored))
        found.emplace_back(rank, entry.path());
    std::sort(found.begin(), found.end());
    for (const auto& [rank, file] : found)
      if (hasPoses(file)) return file;
  }
  return {};
}

}  // namespace facetloc::internal
