// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"

#include <filesystem>
#include <string>
#include <vector>

namespace facetloc {

/** \brief The name of a tool after `facetloc`, and its purpose. */
struct FrontCommand {
  std::string name;
  std::string what;
};
/** \brief Commands in the order in which a newcomer needs them. All but `try` are programs of their own,
 * facetloc_NAME. */
const std::vector<FrontCommand>& frontCommands();

/** \brief facetloc: lists the tools, runs `try`, and becomes the tool that its first argument names, in this
 * process. \param tools folder of the programs; where one is not there, it is looked for in PATH \return the
 * exit code */
int runFront(const std::vector<std::string>& arguments, Console console, const std::filesystem::path& tools);

}  // namespace facetloc
