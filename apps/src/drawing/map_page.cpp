// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/map_page.h"

#include "cli/text.h"
#include "drawing/html_text.h"
#include "drawing/map_page_data.h"
#include "drawing/page_files.h"

#include <facetloc/io/atomic_file.h>

namespace facetloc {
void writeMapPage(const std::filesystem::path& path, const Map& map, const MapPage& content) {
  const std::string scripts = pageFile("three_license.js") + pageFile("three.js") + "\n" +
                              pageFile("orbit.js") + "\n" + pageFile("map.js");
  const std::string page = filledPage("map.html", {{"TITLE", htmlEscaped(printable(content.title))},
                                                   {"STYLE", pageFile("map.css")},
                                                   {"SCRIPT", scripts},
                                                   {"DATA", scriptText(mapPageData(map, content, path))}});
  writeTextAtomically(path, [&](std::ostream& out) { out << page; });
}

}  // namespace facetloc
