// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/io/png.h>

class vtkRenderWindow;

namespace facetloc {

/** \brief Makes a window one that nobody sees and that renders the same everywhere. [px] */
void setOffscreen(vtkRenderWindow* window, int width, int height);
/** \brief What a window shows, RGB. */
Raster<std::uint8_t> grabbed(vtkRenderWindow* window);
/** \brief Renders a window and returns what is in it, RGB. */
Raster<std::uint8_t> rendered(vtkRenderWindow* window);

}  // namespace facetloc
