// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/colours.h"

#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace facetloc {

/** \brief A line through points in a chart. */
struct Curve {
  std::string label;  ///< entry of the legend; none if empty
  std::vector<double> x;
  std::vector<double> y;
  Colour colour = kCurveColours[0];
  float width = 2.5f;
  bool dashed = false;
  bool markers = false;
};

/** \brief A chart, and where it is in the picture. */
struct Panel {
  std::string title;
  std::string x_title;
  std::string y_title;
  double x_min = 0;
  double x_max = 1;
  double y_min = 0;
  double y_max = 1;
  bool logarithmic_x = false;
  bool whole_x = false;  ///< ticks at whole numbers only
  std::vector<Curve> curves;
  std::array<float, 4> place = {0, 0, 1, 1};  ///< left, bottom, width, height, as shares of the picture
};

/** \brief Draws charts into a PNG, atomically. Needs an X display (OffscreenDisplay). Throws IoError. */
void drawCharts(const std::filesystem::path& path, int width, int height, const std::vector<Panel>& panels);

}  // namespace facetloc
