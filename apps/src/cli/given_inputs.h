// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

/** \file
 * Inputs at a wrong place of the command line. */

namespace facetloc {

/** \brief Is it a map, by its name? */
bool isMap(const std::filesystem::path& path);

/** \brief A path of the command line, and its word in the usage: MAP.flmap, RECORDING, RESULTS, ... */
struct GivenInput {
  std::string word, path;
};
/** \brief "walk is a recording", "walk.flmap is a map", ...: the inputs that are not of the kind of their
 * word, as far as that is plain without reading them. */
std::vector<std::string> misplacedInputs(const std::vector<GivenInput>& inputs);

}  // namespace facetloc
