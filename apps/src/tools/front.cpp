// SPDX-License-Identifier: BSD-3-Clause
#include "cli/tools.h"

#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <unistd.h>

namespace facetloc {
namespace {

/** Returns only if the program cannot be run. */
int become(const std::string& command, const std::filesystem::path& tools,
           const std::vector<std::string>& arguments, const Console& console) {
  const std::string program = "facetloc_" + command;
  std::vector<std::string> copies = {program};
  copies.insert(copies.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& argument : copies) argv.push_back(argument.data());
  argv.push_back(nullptr);
  execv((tools / program).c_str(), argv.data());
  execvp(program.c_str(), argv.data());
  console.error(fmt::format("{} cannot be run: {}", program, std::strerror(errno)));
  return kFailed;
}

}  // namespace

CommandProgram frontProgram(const std::filesystem::path& tools) {
  CommandProgram program{
      "facetloc",
      "Finds where a depth camera is, from the planes that it sees.",
      {},
      "'facetloc map build' is the program facetloc_map with the argument build.\n\n"
      "Examples:\n  facetloc try walk1 walk2            # a map of walk1, walk2 in it, a report\n"
      "  facetloc simulate office -o office  # recordings, if you have none\n"};
  program.commands.push_back(
      {"try", "", "go from a recording to a report: check, map, localization, evaluation",
       [](const auto& arguments, const Console& console) { return tryApp()->run(arguments, console); }});
  for (const auto& [name, what] :
       {std::pair("check", "check a recording and how it is read"),
        {"map", "build, extend, merge, check and export maps"},
        {"localize", "find where depth images were taken in a map"},
        {"evaluate", "compare results with the truth, in a report"},
        {"render", "draw maps and results, for a browser or as pictures"},
        {"live", "segment and localize a live depth camera, or make a map with it"},
        {"segment", "segment depth images into planes"},
        {"register", "find the pose of one depth image relative to another"},
        {"convert", "convert a recording of any layout to a folder of PNG images"},
        {"simulate", "make recordings of simulated places, with the truth"}})
    program.commands.push_back(
        {name, "", what, [command = std::string(name), tools](const auto& arguments, const Console& console) {
           return become(command, tools, arguments, console);
         }});
  return program;
}

}  // namespace facetloc
