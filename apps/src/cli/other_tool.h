// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

/** \file
 * Tools that other tools run, so that only some of them link VTK. */

namespace facetloc {

/** \brief A tool beside this program, or else of the PATH; nothing if it is not installed. */
std::optional<std::filesystem::path> findTool(const std::string& name);

/** \brief Runs a program to its end, with the same output streams. \return its exit code; 127 if it cannot be
 * run, or was killed */
int runProgram(const std::filesystem::path& program, const std::vector<std::string>& arguments);

}  // namespace facetloc
