// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <json/forwards.h>
#include <map>
#include <string>
#include <string_view>

namespace facetloc {

/** \brief Text with &, <, > and quotes as HTML wants them; control characters become spaces. */
std::string htmlEscaped(std::string_view text);
/** \brief Base64 (RFC 4648) with padding, on one line. */
std::string base64(std::string_view bytes);
/** \brief JSON for a script element: no tag begins in it. Numbers have six digits. */
std::string scriptText(const Json::Value& value);

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
