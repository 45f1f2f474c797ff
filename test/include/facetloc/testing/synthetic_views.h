// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/segmentation/view_builder.h>
#include <facetloc/testing/synthetic_depth.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace facetloc::test {

/** \brief The view of a noisy depth image of a scene. */
inline View viewFrom(const Scene& scene, const Eigen::Isometry3d& T_w_c, unsigned seed,
                     double farthest = 20) {
  const DepthImage image = render(scene, smallCamera(), T_w_c, farthest).image;
  return ViewBuilder().build(noisy(image, SensorNoise{}.inverse_depth_std, seed));
}

/** \brief The view as of a camera that is mounted so. */
inline View mounted(View view, const CameraMounting& mounting) {
  Camera camera = view.camera ? *view.camera : Camera();
  camera.mounting = mounting;
  view.camera = std::make_shared<const Camera>(camera);
  return view;
}

/** \brief A corridor along y, 1.8 m wide and 2.4 m high, without ends. */
inline Scene endlessCorridor() {
  Scene faces = box({-0.9, -60, 0}, {0.9, 60, 2.4});
  faces.erase(std::remove_if(faces.begin(), faces.end(),
                             [](const Face& f) { return std::abs(f.x.cross(f.y).y()) > 0.5; }),
              faces.end());
  return faces;
}

/** \brief A room of 6 x 5 x 2.5 m with furniture all around, without equal parts. */
inline Scene largeRoom() {
  return box({0, 0, 0}, {6, 5, 2.5}) + box({4.2, 3.1, 0}, {5.3, 4.4, 0.8}) +
         box({0, 3.2, 0}, {0.5, 4.5, 1.6}) + box({2.4, 4.5, 0}, {3.3, 5, 1.9}) +
         box({5.4, 0.8, 0}, {6, 2.2, 1.1}) + box({1.4, 0, 0}, {2.9, 0.7, 0.9}) +
         box({0, 0.9, 0}, {0.7, 1.7, 0.5});
}

}  // namespace facetloc::test
