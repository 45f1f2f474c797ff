// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>

namespace facetloc {

/** \brief A file of apps/pages, such as "map.js", which ships with the tools; "three.js" and "orbit.js" are
 * the library that draws 3D scenes in browsers and its camera control. Throws std::runtime_error for those
 * two if facetloc was built without them. */
std::string pageFile(const std::string& name);

/** \brief Whether there is a file of this name, such as "chart.js", the library that draws charts in
 * browsers. */
bool hasPageFile(const std::string& name);

/** \brief A page of apps/pages with the places in it, such as \@TITLE\@, filled in. Texts are inserted as
 * they are. */
std::string filledPage(const std::string& name, const std::map<std::string, std::string>& texts);

}  // namespace facetloc
