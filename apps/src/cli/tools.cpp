// SPDX-License-Identifier: BSD-3-Clause
#include "cli/tools.h"

#include "cli/text.h"

#include <algorithm>
#include <fmt/format.h>

namespace facetloc {
namespace {

bool isOption(const std::string& argument, const std::string& name) {
  return argument == "-" + name || argument == "--" + name;
}

std::string usageOf(const Command& command) {
  return command.name + (command.arguments.empty() ? "" : " ") + command.arguments;
}

}  // namespace

std::string CommandProgram::usage() const {
  std::size_t width = 0;
  for (const Command& command : commands) width = std::max(width, usageOf(command).size());
  std::string text = fmt::format("Usage: {} COMMAND ...\n\n{}\n\nCommands:\n", name, about);
  for (const Command& command : commands)
    text += fmt::format("  {:{}}  {}\n", usageOf(command), width, command.what);
  return text + fmt::format("\n'{} help COMMAND' lists the options of a command.\n{}", name, epilogue);
}

int CommandProgram::execute(std::vector<std::string> arguments, const Console& console) const {
  const auto take = [&arguments] {
    std::string first = arguments.empty() ? "--help" : arguments.front();
    if (!arguments.empty()) arguments.erase(arguments.begin());
    return first;
  };
  std::string word = take();
  if (isOption(word, "version")) return console.print(versionText() + "\n"), kOk;
  if (word == "help" && !arguments.empty()) {
    word = take();
    arguments.emplace_back("--help");
  }
  if (word == "help" || isOption(word, "help") || isOption(word, "h")) return console.print(usage()), kOk;
  std::vector<std::string> names;
  for (const Command& command : commands) {
    if (command.name == word) return command.run(arguments, console);
    names.push_back(command.name);
  }
  const std::string meant = didYouMean(word, names);
  console.error(fmt::format("unknown command '{}'{}\n{}", word, meant,
                            meant.empty() ? usage() : fmt::format("Try '{} --help'.", name)));
  return kUsage;
}

int CommandProgram::run(const std::vector<std::string>& arguments, Console console) const {
  console.tool = name;
  const int code = execute(arguments, console);
  if (code != kOk || console.out) return code;
  console.error("the output cannot be written");
  return kFailed;
}

}  // namespace facetloc
