// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace facetloc {

/** \brief Makes the place index of a map and writes it into its file, unless it is there already, or the map
 * is one that openMap() reads as a whole, of whose views an index is soon made, or the camera's mounting is
 * not known. Throws IoError. */
void writePlaceIndex(const std::filesystem::path& map);

/** \brief What is wrong with the place index in a map file, in words; empty if it is sound or there is none.
 */
std::vector<std::string> placeIndexFaults(const std::filesystem::path& map);

}  // namespace facetloc
