// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/pose.h>
#include <facetloc/simulation/simulated_camera.h>

#include <cmath>
#include <random>

namespace facetloc::benchmarks {

constexpr std::uint64_t kSeed = 7;
constexpr int kBoxes = 90;  // boxes in a cluttered room

inline Eigen::Isometry3d cameraPose(double x, double y, double heading) {
  return Eigen::Translation3d(x, y, 0) * Eigen::Isometry3d(expSO3({0, 0, heading})) *
         CameraMounting{1.0, 10.0}.T_b_c();
}

// A room full of boxes, on the floor and on shelves, with free space in the middle: about twenty segments per
// view.
inline SimulatedWorld clutteredRoom(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&random](double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random);
  };
  SimulatedWorld scene;
  std::uint16_t id = 1;
  Eigen::Isometry3d T(Eigen::Translation3d(0, 0, 1.5));
  addBox(scene, T, {5, 5, 1.5}, id);
  for (int i = 0; i < kBoxes; ++i) {
    const double bearing = uniform(0, 360 * kDegree), distance = uniform(2.0, 4.5);
    T.translation() << distance * std::cos(bearing), distance * std::sin(bearing), uniform(0.2, 2.4);
    T.linear() = expSO3({0, 0, uniform(0, 90 * kDegree)});
    addBox(scene, T, {uniform(0.15, 0.5), uniform(0.15, 0.5), uniform(0.1, 0.4)}, id);
  }
  return scene;
}

}  // namespace facetloc::benchmarks
