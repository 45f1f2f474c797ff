// SPDX-License-Identifier: BSD-3-Clause
#include "live/pclzf_folder.h"

#include "base/text.h"

#include <facetloc/io/error.h>
#include <facetloc/io/pclzf.h>

#include <cctype>
#include <fmt/format.h>
#include <string>
#include <string_view>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExtension = ".pclzf";

bool isDepth(const fs::path& file) {
  return text::lowerExtension(file) == kExtension &&
         file.filename().string().find("depth") != std::string::npos;
}

/** frame_20121214T142255.814212_depth.pclzf; digits where the pattern has a 0. */
void requireTime(const fs::path& file) {
  constexpr std::string_view kPattern = "frame_00000000T000000.000000_";
  const std::string name = file.filename().string();
  bool fits = name.size() >= kPattern.size();
  for (std::size_t i = 0; fits && i < kPattern.size(); ++i)
    fits =
        kPattern[i] == '0' ? std::isdigit(static_cast<unsigned char>(name[i])) != 0 : name[i] == kPattern[i];
  if (!fits)
    throw IoError(
        file.string(),
        "its name tells no time as PCL's recorder writes it, frame_20121214T142255.814212_depth.pclzf");
}

}  // namespace

bool isPclzfFolder(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) return false;
  for (const auto& entry : fs::directory_iterator(path, ignored))
    if (text::lowerExtension(entry.path()) == kExtension) return true;
  return false;
}

void requireSoundPclzfFolder(const fs::path& folder) {
  std::size_t images = 0, cameras = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const fs::path& file = entry.path();
    if (isDepth(file)) {
      requireTime(file);
      requireSoundPclzf(file);
      ++images;
    } else if (text::lowerExtension(file) == ".xml") {
      requireTime(file.parent_path() / (file.stem().string() + "_"));
      readPclzfCamera(file, 1, 1);
      ++cameras;
    }
  }
  if (cameras < images)
    throw IoError(folder.string(), fmt::format("has {} depth images, but only {} .xml files of their camera",
                                               images, cameras));
}

}  // namespace facetloc
