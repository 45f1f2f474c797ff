// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

/** \file
 * The keys of small files in YAML and JSON. Private to io. */

namespace facetloc::internal {

/** \brief A key with the numbers and the word behind it, up to the next key. */
struct YamlEntry {
  std::string key;  ///< lower case, the last part of a.b.c
  std::vector<double> numbers;
  std::string word;
  std::size_t end = 0;  ///< place of the key in the text
};

/** \brief The keys in their order, whatever their nesting. Total: any text has entries, or none. */
std::vector<YamlEntry> yamlEntries(std::string_view text);

/** \brief All that stands behind a key on its line, such as a file name with blanks: without quotes around it
 * and without a comment. */
std::string_view lineBehind(const YamlEntry& entry, std::string_view text);

}  // namespace facetloc::internal
