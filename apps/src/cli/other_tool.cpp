// SPDX-License-Identifier: BSD-3-Clause
#include "cli/other_tool.h"

#include "base/text.h"

#include <cstdlib>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace facetloc {

namespace fs = std::filesystem;

std::optional<fs::path> findTool(const std::string& name) {
  std::error_code ignored;
  std::vector<fs::path> folders = {fs::read_symlink("/proc/self/exe", ignored).parent_path()};
  if (const char* path = std::getenv("PATH"))
    for (const std::string_view folder : text::split(path, ':')) folders.emplace_back(folder);
  for (const fs::path& folder : folders)
    if (!folder.empty() && access((folder / name).c_str(), X_OK) == 0) return folder / name;
  return {};
}

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

}  // namespace facetloc
