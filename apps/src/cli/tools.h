// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace facetloc {

/** \brief Makes a tool of the command line. Its options and its work are in the file of its name. */
using MakeApp = std::unique_ptr<App>();
MakeApp checkApp, convertApp, evaluateApp, liveApp, localizeApp, registerApp, renderApp, segmentApp,
    simulateApp, tryApp;
/** \brief Makes a command of facetloc_map. */
MakeApp mapBuildApp, mapCalibrateApp, mapChangesApp, mapCheckApp, mapDensifyApp, mapExportApp, mapExtendApp,
    mapImportApp, mapInfoApp, mapMergeApp, mapModelApp;

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

/** \brief facetloc_map. */
const CommandProgram& mapProgram();
/** \brief facetloc: its commands in the order in which a newcomer needs them. `try` runs here; each other one
 * becomes the program facetloc_NAME, in this process.
 * \param tools folder of the programs; one that is not there is looked for in PATH */
CommandProgram frontProgram(const std::filesystem::path& tools);

}  // namespace facetloc
