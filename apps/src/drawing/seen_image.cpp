// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/depth_drawing.h"
#include "drawing/pictures.h"

#include <fmt/format.h>
#include <stdexcept>
#include <utility>

namespace facetloc {

SeenImage seeSegments(const std::string& name, View view) {
  SeenImage image;
  image.name = name + ", by its segments";
  image.depth = depthOf(view);
  image.labels = seenSegments(view);
  for (int v = 0; v < image.labels.height; ++v)
    for (int u = 0; u < image.labels.width; ++u) {
      const std::size_t pixel = static_cast<std::size_t>(v) * image.labels.width + u;
      const std::size_t label = image.labels.label[pixel];
      if (label == 0) continue;
      const Segment& s = view.segments[label - 1];
      const double along = s.normal().dot(image.depth.camera.ray(u, v));
      if (along > 0) image.depth.depth[pixel] = static_cast<float>(s.offset() / along);
    }
  image.view = std::move(view);
  return image;
}

void checkDrawable(const SeenImage& image) {
  if (!image.depth.valid())
    throw std::invalid_argument(fmt::format("the image {} has no pixels to draw", image.name));
  if (image.labels.width != image.depth.camera.width || image.labels.height != image.depth.camera.height)
    throw std::invalid_argument(fmt::format("the labels of image {} are of another size", image.name));
}

}  // namespace facetloc
