// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"

#include <functional>
#include <string>
#include <vector>

namespace facetloc {

/** \brief A command of a program that has several: its name, the usage of its arguments, and its purpose. */
struct Command {
  std::string name, arguments, what;
  std::function<int(const std::vector<std::string>& arguments, const Console& console)> run;  ///< exit code
};

/** \brief A program of commands: PROGRAM COMMAND ..., PROGRAM help [COMMAND], --help and --version. */
struct CommandProgram {
  std::string name, about;
  std::vector<Command> commands;
  std::string epilogue{};  ///< end of the list of commands, whole lines

  /** \brief The list of commands. */
  std::string usage() const;
  /** \brief Runs the command that the first argument names; without arguments, lists all. \return the exit
   * code */
  int run(const std::vector<std::string>& arguments, Console console) const;

private:
  int execute(std::vector<std::string> arguments, const Console& console) const;
};

}  // namespace facetloc
