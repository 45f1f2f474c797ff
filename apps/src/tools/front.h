// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/commands.h"

#include <filesystem>

namespace facetloc {

/** \brief facetloc: its commands in the order in which a newcomer needs them. `try` runs here; each other one
 * becomes the program facetloc_NAME, in this process.
 * \param tools folder of the programs; one that is not there is looked for in PATH */
CommandProgram frontProgram(const std::filesystem::path& tools);

}  // namespace facetloc
