// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/features/local_model.h>
#include <facetloc/segmentation/view_builder.h>

#include <optional>
#include <string>
#include <utility>

namespace facetloc {

/** \brief A depth image and its segments. */
struct SeenImage {
  std::string name;
  DepthImage depth;   ///< at the working size
  LabelImage labels;  ///< k = segment k - 1 of the view
  View view;
};

/** \brief Segments an image of the working size. */
inline SeenImage see(const std::string& name, DepthImage depth, ViewBuilder& builder,
                     const std::optional<Gravity>& gravity = {}) {
  SeenImage image{name, std::move(depth), {}, {}};
  image.view = builder.build(image.depth, gravity);
  image.labels = builder.segmentation().labels;
  return image;
}

}  // namespace facetloc
