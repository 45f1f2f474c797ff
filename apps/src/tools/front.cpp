// SPDX-License-Identifier: BSD-3-Clause
#include "tools/front.h"

#include "cli/spelling.h"
#include "cli/tools.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <unistd.h>

namespace facetloc {
namespace {

std::string usage() {
  std::string text = "Usage: facetloc COMMAND ...\n\nFinds where a depth camera is, from the planes that it "
                     "sees.\n\nCommands:\n";
  for (const FrontCommand& command : frontCommands())
    text += fmt::format("  {:10} {}\n", command.name, command.what);
  return text + "\n'facetloc COMMAND --help' says more; 'facetloc map build' is the program facetloc_map "
                "with the argument build.\n\n"
                "Examples:\n  facetloc try walk1 walk2            # a map of walk1, walk2 in it, a report\n"
                "  facetloc simulate office -o office  # recordings, if you have none\n";
}

/** Returns only if the program cannot be run. */
void become(const std::string& command, const std::vector<std::string>& arguments,
            const std::filesystem::path& tools) {
  const std::string program = "facetloc_" + command;
  std::vector<std::string> copies = {program};
  copies.insert(copies.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& argument : copies) argv.push_back(argument.data());
  argv.push_back(nullptr);
  execv((tools / program).c_str(), argv.data());
  execvp(program.c_str(), argv.data());
}

}  // namespace

const std::vector<FrontCommand>& frontCommands() {
  static const std::vector<FrontCommand> commands = {
      {"try", "go from a recording to a report: check, map, localization, evaluation"},
      {"check", "check a recording and how it is read"},
      {"map", "build, extend, merge, check and export maps"},
      {"localize", "find where depth images were taken in a map"},
      {"evaluate", "compare results with the truth, in a report"},
      {"render", "draw maps and results, for a browser or as pictures"},
      {"live", "segment and localize a live depth camera, or make a map with it"},
      {"segment", "segment depth images into planes"},
      {"register", "find the pose of one depth image relative to another"},
      {"convert", "convert a recording of any layout to a folder of PNG images"},
      {"simulate", "make recordings of simulated places, with the truth"}};
  return commands;
}

int runFront(const std::vector<std::string>& arguments, Console console, const std::filesystem::path& tools) {
  console.tool = "facetloc";
  const std::string command = arguments.empty() ? "--help" : arguments.front();
  const std::vector<std::string> rest(arguments.begin() + (arguments.empty() ? 0 : 1), arguments.end());
  if (command == "--help" || command == "-h" || command == "help") return console.print(usage()), kOk;
  if (command == "--version") return console.print(versionText() + "\n"), kOk;
  if (command == "try") return tryApp()->run(rest, console);
  std::vector<std::string> names;
  for (const FrontCommand& known : frontCommands()) names.push_back(known.name);
  if (std::find(names.begin(), names.end(), command) == names.end()) {
    console.error(fmt::format("unknown command '{}'{}\n{}", command, didYouMean(command, names), usage()));
    return kUsage;
  }
  become(command, rest, tools);
  console.error(fmt::format("facetloc_{} cannot be run: {}", command, std::strerror(errno)));
  return kFailed;
}

}  // namespace facetloc
