// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/lens_distortion.h>

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

namespace facetloc {
namespace {

const Intrinsics kCamera{160, 144, 126, 126, 79.5, 72.5};

/** A wide time-of-flight camera has one as strong. */
LensDistortion wideLens() {
  LensDistortion lens;
  lens.k1 = 4.7, lens.k2 = 3.2, lens.k3 = 0.17, lens.k4 = 5.05, lens.k5 = 4.8, lens.k6 = 0.89;
  lens.p1 = 1e-4, lens.p2 = -2e-4;
  return lens;
}

/** A scene as the camera with the lens stores it, by the depth along each ray. */
template <typename DepthOf>
DepthImage storedImage(const LensDistortion& lens, DepthKind kind, DepthOf depthOf) {
  DepthImage image{kCamera, {}};
  for (int v = 0; v < kCamera.height; ++v)
    for (int u = 0; u < kCamera.width; ++u) {
      const auto ray = lens.undistorted(kCamera.ray(u, v).head<2>());
      double z = ray ? depthOf(*ray) : 0;
      if (ray && kind == DepthKind::distance) z *= std::sqrt(1 + ray->squaredNorm());
      image.depth.push_back(static_cast<float>(z));
    }
  return image;
}

double planeAt(const Eigen::Vector2d& ray) { return 1.5 / (1 + 0.6 * ray.x() - 0.4 * ray.y()); }

TEST(LensDistortion, NoneLeavesRaysWhereTheyAre) {
  const LensDistortion none;
  EXPECT_TRUE(none.isNone());
  EXPECT_EQ(none.distorted({0.3, -0.7}), Eigen::Vector2d(0.3, -0.7));
  EXPECT_EQ(none.largestRadius(), 10);
}

TEST(LensDistortion, IsThatOfOpenCvsFormula) {
  LensDistortion lens;
  lens.k1 = 0.1, lens.k2 = 0.02, lens.k3 = 0.003, lens.k4 = 0.2, lens.k5 = 0.01, lens.k6 = 0.001;
  lens.p1 = 0.01, lens.p2 = 0.02;
  // r^2 = 0.25, radial 1.0262969 / 1.050640625
  const double scale = (1 + 0.1 * 0.25 + 0.02 * 0.0625 + 0.003 * 0.015625) /
                       (1 + 0.2 * 0.25 + 0.01 * 0.0625 + 0.001 * 0.015625);
  const Eigen::Vector2d seen = lens.distorted({0.3, 0.4});
  EXPECT_NEAR(seen.x(), 0.3 * scale + 2 * 0.01 * 0.12 + 0.02 * (0.25 + 0.18), 1e-15);
  EXPECT_NEAR(seen.y(), 0.4 * scale + 0.01 * (0.25 + 0.32) + 2 * 0.02 * 0.12, 1e-15);
}

TEST(LensDistortion, RoundTrips) {
  const LensDistortion lens = wideLens();
  for (double x = -1.1; x <= 1.1; x += 0.1)
    for (double y = -1.1; y <= 1.1; y += 0.1) {
      const Eigen::Vector2d ray(x, y);
      const auto found = lens.undistorted(lens.distorted(ray));
      if (ray.norm() > lens.largestRadius()) continue;
      ASSERT_TRUE(found) << ray.transpose();
      EXPECT_LT((*found - ray).norm(), 1e-7) << ray.transpose();
    }
}

TEST(LensDistortion, BeyondItsLargestRadiusThereIsNoRay) {
  LensDistortion lens;
  lens.k1 = -0.3;  // r (1 - 0.3 r^2) is largest at 1 / sqrt(0.9)
  EXPECT_NEAR(lens.largestRadius(), 1 / std::sqrt(0.9), 2e-3);
  EXPECT_FALSE(lens.undistorted({0.9, 0}));
  EXPECT_TRUE(lens.undistorted({0.6, 0}));
}

TEST(LensCorrection, GivesThePlaneThatAPinholeCameraSees) {
  for (const DepthKind kind : {DepthKind::z, DepthKind::distance})
    for (const LensDistortion& lens : {LensDistortion(), wideLens()}) {
      const LensCorrection correction(kCamera, lens, kind);
      const DepthImage image = correction(storedImage(lens, kind, planeAt));
      std::size_t measured = 0;
      for (int v = 0; v < kCamera.height; ++v)
        for (int u = 0; u < kCamera.width; ++u)
          if (image.at(u, v) > 0) {
            ++measured;
            EXPECT_NEAR(image.at(u, v), planeAt(kCamera.ray(u, v).head<2>()), 1e-3) << u << " " << v;
          }
      EXPECT_GT(measured, 0.8 * double(image.depth.size()));
    }
}

TEST(LensCorrection, NeverMixesTheDepthsOfTwoSidesOfAnEdge) {
  const auto scene = [](const Eigen::Vector2d& ray) { return ray.norm() < 0.3 ? 1.0 : 2.5; };
  const DepthImage image = LensCorrection(kCamera, wideLens())(storedImage(wideLens(), DepthKind::z, scene));
  for (const float z : image.depth)
    EXPECT_TRUE(z == 0 || std::abs(z - 1) < 1e-3 || std::abs(z - 2.5) < 1e-3) << z;
  EXPECT_NEAR(image.at(80, 72), 1, 1e-3);
}

TEST(LensCorrection, UnmeasuredPixelsStayUnmeasured) {
  DepthImage stored = storedImage(wideLens(), DepthKind::z, planeAt);
  for (int u = 60; u < 70; ++u)
    for (int v = 60; v < 70; ++v)
      stored.depth[static_cast<std::size_t>(v * kCamera.width + u)] = u % 2 ? 0.f : NAN;
  const DepthImage image = LensCorrection(kCamera, wideLens())(stored);
  EXPECT_EQ(image.at(65, 65), 0);
  for (const float z : image.depth) EXPECT_TRUE(std::isfinite(z));
}

TEST(LensCorrection, RefusesCamerasAndImagesThatCannotBe) {
  EXPECT_THROW(LensCorrection(Intrinsics(), wideLens()), std::invalid_argument);
  const LensCorrection correction(kCamera, wideLens());
  EXPECT_TRUE(correction({kCamera, {1, 2, 3}}).empty());
  EXPECT_TRUE(correction({{2, 1, 1, 1, 0, 0}, {1, 1}}).empty());
}

TEST(LensCorrection, AnInvalidLensSeesNothing) {
  LensDistortion lens;
  lens.k4 = -1e4;
  const DepthImage image = LensCorrection(kCamera, lens, DepthKind::distance)(
      {kCamera, std::vector<float>(std::size_t(kCamera.width) * kCamera.height, 1.f)});
  for (const float z : image.depth) EXPECT_TRUE(std::isfinite(z) && z >= 0);
}

}  // namespace
}  // namespace facetloc
