// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/charts.h"

#include <string>

namespace facetloc {

/** \brief A chart as a figure of an HTML page: an SVG that fits the width that it is given, and its legend in
 * words below. Text and grid have the page's colours, so that it is legible in the dark. Its place in a
 * picture does not count. */
std::string svgChart(const Panel& panel);

}  // namespace facetloc
