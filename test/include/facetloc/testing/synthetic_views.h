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

/** \brief On a circle about the middle of the large room, looking outwards and down. */
inline Eigen::Isometry3d onCircle(double degrees, double radius, double height = 1.2, double down = 0.4) {
  const double a = degrees * kDegree;
  return lookingAlong({3 + radius * std::cos(a), 2.5 + radius * std::sin(a), height},
                      {std::cos(a), std::sin(a), -down});
}

/** \brief An endless corridor with the same niche on both sides every 1.8 m. */
inline Scene corridorWithNiches() {
  Scene scene = endlessCorridor();
  for (int k = -20; k <= 20; ++k) {
    const double y = 1.8 * k;
    scene = scene + box({-0.9, y, 0}, {-0.75, y + 0.9, 2.4}) + box({0.75, y, 0}, {0.9, y + 0.9, 2.4});
  }
  return scene;
}

/** \brief A camera in the middle of that corridor. */
inline Eigen::Isometry3d alongCorridor(double y) { return lookingAlong({0, y, 1.2}, {0.03, 1, -0.2}); }

}  // namespace facetloc::test
