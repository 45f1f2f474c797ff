// SPDX-License-Identifier: BSD-3-Clause
#include "tools/drawn_map.h"

#include "base/text.h"
#include "drawing/offscreen_display.h"
#include "outputs/output_folder.h"

#include <facetloc/io/error.h>

#include <cstdlib>
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

}  // namespace

DrawnMap::DrawnMap(fs::path picture) : picture_(std::move(picture)) {
  requireReplaceable(picture_);
  if (!FACETLOC_WITH_VTK) throw IoError(picture_.string(), std::string("cannot be drawn: ") + kWithoutVtk);
  const auto renderer = findTool("facetloc_render");
  if (!renderer)
    throw IoError(
        picture_.string(),
        "cannot be drawn: facetloc_render is not installed, which is in the package facetloc-tools-gui");
  renderer_ = *renderer;
}

void DrawnMap::draw(const fs::path& map, const fs::path& plan) const {
  std::vector<std::string> arguments = {map.string(), "-o", picture_.string(), "--quiet"};
  if (!plan.empty()) arguments.insert(arguments.end(), {"--grid", plan.string()});
  if (runProgram(renderer_, arguments) != 0)
    throw IoError(picture_.string(),
                  "is not drawn by " + renderer_.string() + "; the map is in " + map.string());
}

}  // namespace facetloc
