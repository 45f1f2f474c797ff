// SPDX-License-Identifier: BSD-3-Clause
#include "facts.h"
#include "quad_tree.h"

#include <facetloc/segmentation/view_builder.h>
#include <facetloc/simulation/simulated_camera.h>
#include <facetloc/simulation/simulated_drive.h>
#include <facetloc/testing/synthetic_depth.h>

namespace facetloc::figures {

Json::Value splitFacts() {
  const SimulatedWorld room = furnishedRoom(7);
  const Eigen::Isometry3d T = test::lookingAlong({0, 0, 1}, {1, -0.4, -0.2});
  const DepthImage image = SimulatedCamera(kinectIntrinsics().subsampled(2), {}, 1).render(room, T, 0).depth;
  ViewBuilder builder;
  const View view = builder.build(image);
  const LabelledPlanes& found = builder.segmentation();

  internal::DisparityImage disparity;
  internal::toDisparity(image, found.noise, disparity);
  internal::QuadTree tree;
  tree.compute(disparity);

  Json::Value out;
  out["depth"] = smallDepth(image), out["segments"] = static_cast<int>(view.segments.size());
  for (const internal::QuadTree::Leaf& leaf : tree.leaves()) {
    Json::Value square(Json::arrayValue);
    square.append(leaf.u), square.append(leaf.v), square.append(leaf.size);
    out["leaves"].append(square);
  }
  for (int v = 0; v < found.labels.height; v += 2) {
    Json::Value line(Json::arrayValue);
    for (int u = 0; u < found.labels.width; u += 2)
      line.append(found.labels.label[static_cast<std::size_t>(v) * found.labels.width + u]);
    out["labels"].append(line);
  }
  return out;
}

}  // namespace facetloc::figures
