// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "bytes/files.h"

#include <facetloc/io/rig_file.h>

#include <fmt/format.h>
#include <set>
#include <stdexcept>
#include <string>

namespace facetloc {
namespace {

constexpr const char* kName = "rig.ini";
constexpr double kLargestRotationDeg = 20, kLargestTranslation = 1;  // errors of a mounting [deg, m]

class Parser {
public:
  explicit Parser(fs::path path) : path_(std::move(path)) {}

  RigFile parse(std::string_view content) {
    files::forEachLine(content, path_.string(), [this](std::string_view line) {
      const std::string_view pair = text::trimmed(text::withoutComment(line));
      if (pair.empty()) return;
      const auto equals = pair.find('=');
      if (equals == std::string_view::npos) fail("expected key = value at " + text::quoted(pair));
      store(text::trimmed(pair.substr(0, equals)), text::trimmed(pair.substr(equals + 1)));
    });
    if (rig_.cameras.size() < 2)
      throw IoError(path_.string(), "names fewer than two cameras (cameras = ...)");
    return rig_;
  }

private:
  [[noreturn]] static void fail(const std::string& cause) { throw std::invalid_argument(cause); }
  void store(std::string_view key, std::string_view value) {
    if (!known_.emplace(key).second) fail(fmt::format("{} is given twice", key));
    if (key == "cameras") return storeCameras(value);
    if (key == "rotation_std_deg")
      rig_.rotation_std = number(key, value, kLargestRotationDeg) * kDegree;
    else if (key == "translation_std")
      rig_.translation_std = number(key, value, kLargestTranslation);
    else
      fail(fmt::format("unknown key '{}' (known: cameras, rotation_std_deg, translation_std)", key));
  }
  void storeCameras(std::string_view names) {
    std::set<fs::path> all;
    for (const std::string_view name : text::words(names)) {
      rig_.cameras.push_back(path_.parent_path() / name);
      if (!all.insert(rig_.cameras.back()).second) fail(fmt::format("camera {} is named twice", name));
    }
  }
  double number(std::string_view key, std::string_view value, double largest) const {
    const auto found = text::to<double>(value);
    if (!found || !(*found >= 0 && *found <= largest))
      fail(fmt::format("{} = {} is impossible: it must lie in [0, {}]", key, value, text::shortest(largest)));
    return *found;
  }

  fs::path path_;
  std::set<std::string, std::less<>> known_;
  RigFile rig_;
};

}  // namespace

PoseWithCovariance RigFile::between(const CameraMounting& first, const CameraMounting& other) const {
  Vector6d std;
  std << Eigen::Vector3d::Constant(rotation_std), Eigen::Vector3d::Constant(translation_std);
  return {first.T_b_c().inverse() * other.T_b_c(), std.cwiseAbs2().asDiagonal()};
}

std::optional<RigFile> readRigFile(const fs::path& path) {
  const fs::path file = files::isFolder(path) ? path / kName : path;
  if (file.filename() != kName || !files::isThere(file)) return {};
  return Parser(file).parse(files::readText(file));
}

}  // namespace facetloc
