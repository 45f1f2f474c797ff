// SPDX-License-Identifier: BSD-3-Clause
#include "tools/drawn_map.h"

#include "base/text.h"
#include "outputs/provenance.h"

#include <facetloc/io/error.h>
#include <facetloc/io/trajectory.h>

#include <cstdlib>
#include <fmt/format.h>
#include <optional>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace facetloc {
namespace {

namespace fs = std::filesystem;

/** A tool beside this program, or else of the PATH; nothing if it is not installed. */
std::optional<fs::path> findTool(const std::string& name) {
  std::error_code ignored;
  std::vector<fs::path> folders = {fs::read_symlink("/proc/self/exe", ignored).parent_path()};
  if (const char* path = std::getenv("PATH"))
    for (const std::string_view folder : text::split(path, ':')) folders.emplace_back(folder);
  for (const fs::path& folder : folders)
    if (!folder.empty() && access((folder / name).c_str(), X_OK) == 0) return folder / name;
  return {};
}

/** Runs a program to its end, with the same output streams. \return its exit code; 127 if it cannot be run,
 * or was killed */
int runProgram(const fs::path& program, const std::vector<std::string>& arguments) {
  constexpr int kCannotRun = 127;  // as shells say
  std::vector<std::string> copies = {program.filename().string()};
  copies.insert(copies.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& copy : copies) argv.push_back(copy.data());
  argv.push_back(nullptr);
  pid_t child = 0;
  int status = 0;
  if (posix_spawn(&child, program.c_str(), nullptr, nullptr, argv.data(), environ) != 0) return kCannotRun;
  if (waitpid(child, &status, 0) != child || !WIFEXITED(status)) return kCannotRun;
  return WEXITSTATUS(status);
}

/** Removed with all that is in it. */
class TemporaryFolder {
public:
  TemporaryFolder() {
    std::string name = (fs::temp_directory_path() / "facetloc_XXXXXX").string();
    if (!mkdtemp(name.data())) throw IoError(name, "cannot be created");
    path_ = name;
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  const fs::path& path() const { return path_; }

private:
  fs::path path_;
};

/** Their numbers are their times. */
std::string written(const fs::path& file, const std::vector<Eigen::Isometry3d>& T_w_c) {
  std::vector<StampedPose> poses;
  for (const Eigen::Isometry3d& T : T_w_c) poses.push_back({static_cast<double>(poses.size()), T});
  writeTumTrajectory(file, poses);
  return file.string();
}

}  // namespace

DrawnMap::DrawnMap(fs::path picture) : picture_(std::move(picture)) {
  requireNoneButPicture(picture_);
  const auto renderer = findTool("facetloc_render");
  if (!renderer)
    throw IoError(
        picture_.string(),
        "cannot be drawn: facetloc_render is not installed, which is in the package facetloc-tools-gui");
  renderer_ = *renderer;
}

void DrawnMap::draw(const fs::path& map, const std::vector<Eigen::Isometry3d>& trajectory,
                    const std::vector<Marks>& marks) const {
  const TemporaryFolder folder;
  std::vector<std::string> arguments = {map.string(), "-o", picture_.string(), "--quiet"};
  if (!trajectory.empty())
    arguments.insert(arguments.end(),
                     {"--trajectory", written(folder.path() / "trajectory.txt", trajectory)});
  std::vector<std::string> files;  // without a name where a kind has none: each has its colour
  for (const auto& [name, T_w_c] : marks)
    files.push_back(T_w_c.empty() ? "" : written(folder.path() / (name + ".txt"), T_w_c));
  if (!files.empty())
    arguments.insert(arguments.end(), {"--marks", fmt::format("{}", fmt::join(files, ","))});
  if (runProgram(renderer_, arguments) != 0)
    throw IoError(picture_.string(),
                  "is not drawn by " + renderer_.string() + "; the map is in " + map.string());
}

}  // namespace facetloc
