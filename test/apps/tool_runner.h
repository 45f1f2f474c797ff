// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace facetloc::test {

/** \brief The outcome of a run of a tool. */
struct ToolRun {
  int code = 0;
  std::string out;
  std::string err;
};

template <class Run>
ToolRun captured(const Run& run) {
  std::ostringstream out, err;
  const int code = run(Console{out, err, false, false, {}});
  return {code, out.str(), err.str()};
}

/** \brief Runs a tool as the shell would. */
template <class Tool>
ToolRun runTool(const std::vector<std::string>& arguments) {
  return captured([&](const Console& console) { return Tool().run(arguments, console); });
}

/** \brief A folder that vanishes with the test. */
class TemporaryFolder {
public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "facetloc_apps_XXXXXX").string();
    if (!mkdtemp(name.data())) throw std::runtime_error("no temporary folder");
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

private:
  std::filesystem::path path_;
};

inline std::string contentOf(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline void writeContent(const std::filesystem::path& path, const std::string& content) {
  std::ofstream(path, std::ios::binary) << content;
}

inline std::string lastLine(const std::string& text) {
  std::istringstream in(text);
  std::string last;
  for (std::string line; std::getline(in, line);) last = line;
  return last;
}

}  // namespace facetloc::test
