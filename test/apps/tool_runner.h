// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/tools.h"

#include <facetloc/testing/matchers.h>
#include <facetloc/testing/own_folder.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <sstream>
#include <vector>

namespace facetloc::test {

using Arguments = std::vector<std::string>;
inline Arguments operator+(Arguments arguments, const Arguments& more) {
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

/** \brief The outcome of a run of a tool. */
struct ToolRun {
  int code = 0;
  std::string out;
  std::string err;
};

inline void PrintTo(const ToolRun& run, std::ostream* out) {
  *out << "code " << run.code << "\n" << run.out << run.err;
}

/** \brief A run that must have succeeded for the test to go on. */
inline ToolRun ok(const ToolRun& run) {
  if (run.code != kOk) throw std::runtime_error("code " + std::to_string(run.code) + ": " + run.err);
  return run;
}

/** \brief Matches a run that ends with a code and has each of these words in its errors. */
template <class... Words>
auto ends(int code, const Words&... words) {
  return AllOf(testing::Field("code", &ToolRun::code, code),
               testing::Field("err", &ToolRun::err, HasAll(words...)));
}
template <class... Words>
auto fails(const Words&... words) {
  return ends(kFailed, words...);
}
/** \brief Matches a run that refuses its command line with errors that have these words. */
template <class... Words>
auto refuses(const Words&... words) {
  return ends(kUsage, words...);
}

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
template <MakeApp tool>
ToolRun runTool(const std::vector<std::string>& arguments) {
  return captured([&](const Console& console) { return tool()->run(arguments, console); });
}

/** \brief A folder that vanishes with the test. */
class TemporaryFolder : public OwnFolder {
public:
  std::string operator/(const std::string& name) const { return (path() / name).string(); }
  /** \brief A copy of another folder in it. */
  std::string copyOf(const std::string& other, const std::string& name) const {
    std::filesystem::copy(other, path() / name, std::filesystem::copy_options::recursive);
    return *this / name;
  }
};

/** \brief Tests that each have a folder. */
class InAFolder : public testing::Test {
protected:
  TemporaryFolder folder_;
};

inline std::string contentOf(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline void writeContent(const std::filesystem::path& path, const std::string& content) {
  std::ofstream(path, std::ios::binary) << content;
}

inline std::vector<std::string> linesIn(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}
inline std::string lastLine(const std::string& text) {
  const std::vector<std::string> lines = linesIn(text);
  return lines.empty() ? std::string() : lines.back();
}

/** \brief Files and folders directly in a folder, sorted. */
inline std::vector<std::filesystem::path> filesOf(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace facetloc::test
