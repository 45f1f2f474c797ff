// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/simulation/simulated_camera.h>

#include <cstdint>
#include <vector>

namespace facetloc::test {

const Intrinsics kCamera{320, 240, 262.5, 262.5, 159.5, 119.5};

/** \brief A wall across the optical axis, by default far larger than the image. */
inline Rectangle wallAt(double z, double half = 100, std::uint16_t id = 1) {
  Rectangle wall;
  wall.centre = {0, 0, z};
  wall.half_u = wall.half_v = half, wall.plane_id = id;
  return wall;
}

inline SimulatedWorld sceneOf(const std::vector<Rectangle>& rectangles) { return {rectangles, {}}; }

/** \brief No error but those that the test sets. */
inline SimulatedNoise noErrors() {
  SimulatedNoise noise;
  noise.disparity_std = noise.distortion = noise.quantization = noise.edge_std_px = noise.random_dropout = 0;
  noise.grazing_dropout_deg = 90;
  noise.grazing_spread_deg = noise.dark_range = noise.projector_baseline = 0;
  noise.min_depth = 0, noise.max_depth = 1000;
  return noise;
}

/** \brief The image of a camera at the origin. */
inline SimulatedFrame rendered(const SimulatedNoise& noise, const std::vector<Rectangle>& rectangles,
                               int frame = 0) {
  return SimulatedCamera(kCamera, noise, 1)
      .render(sceneOf(rectangles), Eigen::Isometry3d::Identity(), static_cast<std::uint64_t>(frame));
}

/** \brief The same without any error. */
inline SimulatedFrame exact(const std::vector<Rectangle>& rectangles) {
  return SimulatedCamera(kCamera, noErrors(), 1)
      .renderExact(sceneOf(rectangles), Eigen::Isometry3d::Identity());
}

}  // namespace facetloc::test
