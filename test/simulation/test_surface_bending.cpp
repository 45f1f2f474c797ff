// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/pose.h>
#include <facetloc/simulation/simulated_camera.h>

#include <gtest/gtest.h>

#include <cmath>

namespace facetloc {
namespace {

const Intrinsics kCamera{160, 120, 131.25, 131.25, 79.5, 59.5};

SimulatedWorld wall(double std, std::uint64_t seed = 1) {
  Rectangle r;
  r.centre = {0, 0, 3};
  r.half_u = r.half_v = 100;
  SimulatedWorld scene{{r}, {}};
  scene.bending.std = std, scene.bending.seed = seed;
  return scene;
}

DepthImage seenFrom(const SimulatedWorld& scene, const Eigen::Isometry3d& T_w_c) {
  return SimulatedCamera(kCamera, SimulatedNoise(), 1).renderExact(scene, T_w_c).depth;
}

Eigen::Isometry3d at(double x, double yaw = 0) {
  Eigen::Isometry3d T = Eigen::Isometry3d(Eigen::Translation3d(x, 0, 0));
  T.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY()).toRotationMatrix();
  return T;
}

TEST(SurfaceBending, MovesAWallByThatMuch) {
  double squares = 0, n = 0;
  for (double x = -90; x < 90; x += 2)
    for (const float z : seenFrom(wall(0.02), at(x)).depth) squares += (z - 3) * (z - 3), n += 1;
  EXPECT_NEAR(std::sqrt(squares / n), 0.02, 0.004);
}

TEST(SurfaceBending, IsSmooth) {
  const DepthImage image = seenFrom(wall(0.02), at(0));
  for (int u = 0; u + 1 < kCamera.width; ++u)  // 2.3 cm of wall a pixel, waves of 2 m and more
    EXPECT_LT(std::abs(image.at(u + 1, 60) - image.at(u, 60)), 0.02 * 4 * 0.023 * M_PI) << u;
}

TEST(SurfaceBending, BelongsToTheSurfaceAndNotToTheCamera) {
  const SimulatedWorld scene = wall(0.02);
  const DepthImage first = seenFrom(scene, at(0));
  const Eigen::Isometry3d T = at(0.8, -0.2);
  const DepthImage second = seenFrom(scene, T);
  for (int u = 70; u < 150; u += 5) {
    const Eigen::Vector3d p = first.at(u, 60) * kCamera.ray(u, 60), q = T.inverse() * p;
    const Eigen::Vector2d pixel = kCamera.project(q);
    const int x = static_cast<int>(std::lround(pixel.x())), y = static_cast<int>(std::lround(pixel.y()));
    ASSERT_TRUE(x >= 0 && y >= 0 && x < kCamera.width && y < kCamera.height);
    const Eigen::Vector3d other = T * (second.at(x, y) * kCamera.ray(x, y));
    EXPECT_NEAR(other.z(), p.z(), 0.003) << u;
  }
}

TEST(SurfaceBending, DiffersFromSeedToSeedAndIsOffUnlessAskedFor) {
  EXPECT_NE(seenFrom(wall(0.02, 1), at(0)).depth, seenFrom(wall(0.02, 2), at(0)).depth);
  EXPECT_EQ(seenFrom(wall(0.02, 1), at(0)).depth, seenFrom(wall(0.02, 1), at(0)).depth);
  for (const float z : seenFrom(wall(0), at(0)).depth) EXPECT_EQ(z, 3.f);
}

TEST(SurfaceBending, IsSeenByTheCameraWithItsErrors) {
  SimulatedNoise none;
  none.disparity_std = none.distortion = none.quantization = none.edge_std_px = none.random_dropout = 0;
  none.projector_baseline = 0;
  const DepthImage exact = seenFrom(wall(0.02), at(0));
  const DepthImage image = SimulatedCamera(kCamera, none, 1).render(wall(0.02), at(0), 0).depth;
  for (std::size_t i = 0; i < exact.depth.size(); ++i) EXPECT_NEAR(image.depth[i], exact.depth[i], 1e-5);
}

}  // namespace
}  // namespace facetloc
