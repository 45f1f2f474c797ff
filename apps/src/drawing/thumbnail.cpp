// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/thumbnail.h"

#include "drawing/depth_drawing.h"

#include <vtkImageData.h>
#include <vtkJPEGWriter.h>
#include <vtkNew.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>

namespace facetloc {
namespace {

constexpr int kQuality = 60;

/** The first channel of a picture. */
vtkNew<vtkImageData> greyImage(const Raster<std::uint8_t>& rgb) {
  vtkNew<vtkImageData> image;
  image->SetDimensions(rgb.width, rgb.height, 1);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 1);
  for (int v = 0; v < rgb.height; ++v)
    for (int u = 0; u < rgb.width; ++u)
      *static_cast<std::uint8_t*>(image->GetScalarPointer(u, rgb.height - 1 - v, 0)) =
          rgb.data[(static_cast<std::size_t>(v) * rgb.width + u) * rgb.channels];
  return image;
}

}  // namespace

std::string depthThumbnail(const View& view, int width) {
  if (!view.hasPicture()) return {};
  const Raster<std::uint8_t> grey = greyDepth(depthOf(view));
  const int factor = std::max(1, grey.width / std::max(1, width));
  if (grey.width < factor || grey.height < factor) return {};
  vtkNew<vtkJPEGWriter> writer;
  writer->SetInputData(greyImage(averaged(grey, factor)));
  writer->WriteToMemoryOn();
  writer->SetQuality(kQuality);
  writer->Write();
  const vtkUnsignedCharArray* bytes = writer->GetResult();
  const auto* first = const_cast<vtkUnsignedCharArray*>(bytes)->GetPointer(0);
  return std::string(first, first + bytes->GetNumberOfValues());
}

}  // namespace facetloc
