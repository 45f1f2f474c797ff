// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace facetloc {

/** \brief The names of the parameter files in apps/presets, which ship with the tools. */
std::vector<std::string> presetNames();
/** \brief The text of one of them. Throws UsageError, which lists them, for another name. */
std::string presetText(const std::string& name);

}  // namespace facetloc
