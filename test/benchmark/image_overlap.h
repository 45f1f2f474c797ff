// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>

#include <Eigen/Geometry>

#include <cmath>

namespace facetloc::benchmarks {

/** \brief Share of a's measured pixels that b sees, too, by the true pose of a in the frame of b. */
inline double overlap(const DepthImage& a, const DepthImage& b, const Eigen::Isometry3d& T_b_a) {
  constexpr int kStep = 8;
  constexpr double kSameDepth = 0.05;  // share of the depth
  int valid = 0, shared = 0;
  for (int v = kStep / 2; v < a.camera.height; v += kStep)
    for (int u = kStep / 2; u < a.camera.width; u += kStep) {
      const double z = a.at(u, v);
      if (!(z > 0)) continue;
      ++valid;
      const Eigen::Vector3d p = T_b_a * (z * a.camera.ray(u, v));
      if (!(p.z() > 0)) continue;
      const Eigen::Vector2d q = b.camera.project(p);
      const int x = static_cast<int>(std::lround(q.x())), y = static_cast<int>(std::lround(q.y()));
      if (x < 0 || y < 0 || x >= b.camera.width || y >= b.camera.height) continue;
      const double seen = b.at(x, y);
      shared += seen > 0 && std::abs(seen - p.z()) < kSameDepth * p.z();
    }
  return valid ? shared / static_cast<double>(valid) : 0;
}

}  // namespace facetloc::benchmarks
