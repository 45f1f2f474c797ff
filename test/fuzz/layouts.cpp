// SPDX-License-Identifier: BSD-3-Clause
// A folder as a recording: lines "=NAME", each before the content of that file. Images without content are
// sound.
#include "base/text.h"
#include "bytes/files.h"
#include "fuzz_file.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/error.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace {

using namespace facetloc;
namespace fs = std::filesystem;

/** The name of a file below a folder, and in no other place. */
bool isBelow(const fs::path& name) {
  constexpr std::size_t kLongest = 100;
  return name.has_filename() && name.is_relative() && name.native().size() < kLongest &&
         name.native().find('\0') == std::string::npos && name == name.lexically_normal() &&
         *name.begin() != "..";
}

void putFiles(std::string_view text, const fuzz::Folder& folder) {
  static const std::string image = [&folder] {
    const fs::path png = folder.path() / "depth.png";
    writeDepthPng(png, {{8, 6, 7, 7, 3.5, 2.5}, std::vector<float>(48, 1.5f)}, 1000);
    return files::readBytes(png);
  }();
  folder.clear();
  constexpr int kMostFiles = 40;
  for (int i = 0; i < kMostFiles && !text.empty(); ++i) {
    const std::string_view file = text.substr(0, text.find("\n="));
    text.remove_prefix(std::min(text.size(), file.size() + 2));
    const fs::path name(file.substr(0, file.find('\n')));
    std::error_code ignored;
    if (!isBelow(name) || fs::exists(folder.path() / name, ignored)) continue;
    if (fs::create_directories((folder.path() / name).parent_path(), ignored); ignored) continue;
    const bool is_empty = file.size() <= name.native().size() + 1;
    folder.put(name.c_str(),
               is_empty ? (internal::isPng(name) ? image : "") : file.substr(name.native().size() + 1));
  }
}

void requireSound(const DepthSequence& sequence) {
  std::set<std::string> names;
  double last = -std::numeric_limits<double>::infinity();
  for (const FrameFile& frame : sequence.frames()) {
    fuzz::require(names.insert(frame.name).second, "two images have one name");
    fuzz::require(std::isfinite(frame.stamp), "a time is not finite");
    fuzz::require(frame.stamp >= last, "the times are in no order");
    last = frame.stamp;
  }
  for (std::size_t i = 0; i < sequence.frames().size(); ++i)
    fuzz::accepts<IoError>([&] { fuzz::require(sequence.load(i).valid(), "an image is not valid"); });
  fuzz::accepts<IoError>([&] {
    for (const StampedPose& pose : sequence.groundTruth().poses())
      fuzz::require(pose.T_w_c.matrix().allFinite() && std::isfinite(pose.stamp), "a pose is not finite");
  });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Folder folder;
  if (size == 0 || data[0] != '=') return 0;
  putFiles(fuzz::asText(data + 1, size - 1), folder);
  fuzz::accepts<IoError>([&] { requireSound(DepthSequence::open(folder.path())); });
  RecordingHints hints;
  hints.camera = "kinect";  // whatever the folder lacks
  hints.poses_are = "base";
  fuzz::accepts<IoError>([&] { requireSound(DepthSequence::open(folder.path(), hints)); });
  fuzz::accepts<IoError>([&] { DepthSequence::readTruth(folder.path(), 0.1); });
  return 0;
}
