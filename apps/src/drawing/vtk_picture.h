// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/io/png.h>

#include <vtkNew.h>

class vtkImageData;
class vtkRenderWindow;

namespace facetloc {

/** \brief A picture, RGB, as VTK has it: its first row is the lowest. */
vtkNew<vtkImageData> toImage(const Raster<std::uint8_t>& rgb);

/** \brief Makes a window invisible, and its rendering the same everywhere. [px] */
void setOffscreen(vtkRenderWindow* window, int width, int height);
/** \brief The content of a window that is rendered, RGB. */
Raster<std::uint8_t> grabbed(vtkRenderWindow* window);

}  // namespace facetloc
