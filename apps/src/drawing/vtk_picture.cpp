// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/vtk_picture.h"

#include <vtkImageData.h>
#include <vtkRenderWindow.h>
#include <vtkWindowToImageFilter.h>

#include <algorithm>

namespace facetloc {

vtkNew<vtkImageData> toImage(const Raster<std::uint8_t>& rgb) {
  vtkNew<vtkImageData> image;
  image->SetDimensions(rgb.width, rgb.height, 1);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  const std::size_t row = 3 * static_cast<std::size_t>(rgb.width);
  for (int v = 0; v < rgb.height; ++v)
    std::copy_n(&rgb.data[row * v], row,
                static_cast<std::uint8_t*>(image->GetScalarPointer(0, rgb.height - 1 - v, 0)));
  return image;
}

void setOffscreen(vtkRenderWindow* window, int width, int height) {
  window->SetOffScreenRendering(1);
  window->SetMultiSamples(0);  // the same picture on every machine
  window->SetSize(width, height);
}

Raster<std::uint8_t> grabbed(vtkRenderWindow* window) {
  vtkNew<vtkWindowToImageFilter> filter;
  filter->SetInput(window);
  filter->SetInputBufferTypeToRGB();
  filter->ReadFrontBufferOff();
  filter->ShouldRerenderOff();
  filter->Update();
  vtkImageData* image = filter->GetOutput();
  Raster<std::uint8_t> picture{image->GetDimensions()[0], image->GetDimensions()[1], 3, {}};
  const std::size_t row = 3 * static_cast<std::size_t>(picture.width);
  picture.data.resize(row * picture.height);
  for (int v = 0; v < picture.height; ++v) {  // VTK's first row is the lowest
    const auto* from =
        static_cast<const std::uint8_t*>(image->GetScalarPointer(0, picture.height - 1 - v, 0));
    std::copy(from, from + row, picture.data.begin() + static_cast<std::ptrdiff_t>(row * v));
  }
  return picture;
}

}  // namespace facetloc
