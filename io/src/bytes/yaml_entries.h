// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

/** \file
 * The keys of small files in YAML and JSON, by yaml-cpp. Private to io. */

namespace facetloc::internal {

/** \brief A key with the scalars in its value, up to the next key. */
struct YamlEntry {
  std::string key;                 ///< lower case, the last part of a.b.c
  std::vector<std::string> words;  ///< all scalars as they are written, without quotes
  std::vector<double> numbers;     ///< those in these scalars
};

/** \brief The keys in their order, whatever their nesting; none of a text that is not YAML, or larger than
 * any calibration. */
std::vector<YamlEntry> yamlEntries(std::string_view text);

}  // namespace facetloc::internal
