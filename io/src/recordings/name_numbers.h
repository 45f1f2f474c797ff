// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

/** \file
 * Numbers in the names of images. Private to io. */

namespace facetloc::internal {

/** \brief The numbers by which names differ. */
struct NameNumbers {
  std::vector<double> numbers;  ///< sorted as the names
  bool decimal = false;         ///< one is written with a point
  bool padded = false;          ///< one is written with leading zeros
};

/** \brief The number of each name, which is the name, or a time of PCL's recorders in it, or anywhere in
 * names that are otherwise equal: of several, one that differs from name to name, and has a point if one
 * does. Empty if there are no such numbers. */
std::optional<NameNumbers> numbersInNames(const std::vector<std::string>& names);

/** \brief The time that the name of an image is or has in it, as those of PCL's recorders do, [s]. */
std::optional<double> stampInName(const std::string& name);

/** \brief Is the word there, between what are no letters or at a change from lower to upper case? In lower
 * case; the name in any. */
bool hasWord(const std::string& name, const std::string& word);

}  // namespace facetloc::internal
