// SPDX-License-Identifier: BSD-3-Clause
#include "base/image_noise.h"

#include <facetloc/segmentation/view_builder.h>
#include <facetloc/testing/synthetic_depth.h>

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace facetloc {
namespace {

using namespace internal;
using test::endlessPlane, test::noisy, test::render, test::smallCamera, test::smoothlyNoisy;

constexpr double kStereo = 0.0035;  // [1/m]

Intrinsics finer(Intrinsics camera, int factor) {
  camera.width *= factor, camera.height *= factor, camera.fx *= factor, camera.fy *= factor;
  camera.cx *= factor, camera.cy *= factor;
  return camera;
}

/** A wall 1.5 m ahead, not quite across. */
DepthImage wall(const Intrinsics& camera = smallCamera()) {
  return render({endlessPlane({0, 0, 1.5}, {0.3, 0.2, 1})}, camera).image;
}

std::optional<SmoothNoise> found(const DepthImage& image) {
  std::vector<float> scratch;
  return estimateSmoothNoise(image, scratch);
}

// White noise that was smoothed by a Gaussian of s is correlated by exp(-r^2 / (2 s)^2).
TEST(SmoothNoise, IsFoundWithItsSizeAndLength) {
  for (const int factor : {1, 2})
    for (const double smoothing : {1.5, 2.0, 3.0})
      for (unsigned seed = 0; seed < 3; ++seed) {
        const auto noise =
            found(smoothlyNoisy(wall(finer(smallCamera(), factor)), kStereo, smoothing * factor, seed));
        ASSERT_TRUE(noise) << smoothing << " px of " << 320 * factor;
        EXPECT_NEAR(noise->std, kStereo, 0.15 * kStereo) << smoothing;
        EXPECT_NEAR(noise->correlation_px, 2 * smoothing * factor, 0.25 * 2 * smoothing * factor);
      }
}

TEST(SmoothNoise, IsNotThatOfAKinect) {
  for (unsigned seed = 0; seed < 3; ++seed)
    for (const double du : {0.1, 0.5, 2.0}) {
      EXPECT_FALSE(found(noisy(wall(), du / kKinectGain, seed))) << du;
      EXPECT_FALSE(found(test::rounded(noisy(wall(), du / kKinectGain, seed)))) << du;
      EXPECT_FALSE(found(test::rounded(smoothlyNoisy(wall(), du / kKinectGain, 0.5, seed)))) << du;
    }
}

TEST(SmoothNoise, WithoutPixelsIsZero) {
  EXPECT_FALSE(found({}));
  DepthImage empty = wall();
  std::fill(empty.depth.begin(), empty.depth.end(), 0.f);
  EXPECT_FALSE(found(empty));
  const Intrinsics tiny{16, 12, 13, 13, 7.5, 5.5};
  EXPECT_FALSE(found(smoothlyNoisy(wall(tiny), kStereo, 2, 1)));
}

TEST(SmoothNoise, LeavesAWallInOnePiece) {
  int whole = 0;
  for (unsigned seed = 0; seed < 5; ++seed) {
    const DepthImage image = smoothlyNoisy(wall(), kStereo, 2.6, seed);
    ViewBuilder builder;
    const View view = builder.build(image);
    EXPECT_GT(builder.segmentation().correlation_px, 0);
    ASSERT_FALSE(view.segments.empty());
    whole += view.segments.size() == 1;
    EXPECT_GT(view.segments[0].num_points, 0.9 * 320 * 240) << seed;
    EXPECT_NEAR(view.noise(), kStereo, 0.15 * kStereo);

    ViewParams rough;
    rough.labels.estimate_noise = false;
    EXPECT_GT(ViewBuilder(Camera(), rough).build(image).segments.size(), 2u) << "as it is without";
  }
  EXPECT_GE(whole, 4);  // a few per cent of a wall may still bend too much
}

// Squared errors of the three parameters of a plane in units of their covariance, of which each is 1 if that
// is right.
TEST(SmoothNoise, MakesPlanesAsUncertainAsTheyAre) {
  const Intrinsics part{100, 80, 262.5, 262.5, 49.5, 39.5};  // where the noise counts, and not the distortion
  const Eigen::Vector3d n = Eigen::Vector3d(0.3, 0.2, 1).normalized();
  const double rho = n.dot(Eigen::Vector3d(0, 0, 1.5));
  SegmentEstimationParams of_the_fit;
  of_the_fit.errors = {0, 0, 0};
  double sum = 0;
  int images = 0;
  for (unsigned seed = 0; seed < 100; ++seed) {
    const DepthImage image = smoothlyNoisy(wall(part), kStereo, 2.6, seed);
    LabelImage labels{part.width, part.height, std::vector<std::uint16_t>(image.depth.size(), 1)};
    Camera camera;
    camera.noise.distortion_offset = camera.noise.distortion_slope = 0;
    SensorNoise noise = camera.noise;
    noise.inverse_depth_std = kStereo;
    noise.correlation_px = 5.2 / std::sqrt(scaledPixels(1, part));
    const auto segments = estimateSegments(image, labels, noise, of_the_fit);
    ASSERT_EQ(segments.size(), 1u);
    const Segment& s = segments[0];
    const Eigen::Vector3d of_truth = s.R.transpose() * n;
    const Eigen::Vector3d q(of_truth.x() / of_truth.z(), of_truth.y() / of_truth.z(), rho - n.dot(s.t));
    sum += q.dot(s.Sigma_q.inverse() * q);
    ++images;
  }
  EXPECT_LT(sum / images, 3 * 1.5);
  EXPECT_GT(sum / images, 3 * 0.3);
}

// Noise that neighbours share tilts a strip no more than its surroundings.
TEST(SmoothNoise, KeepsNarrowStrips) {
  DepthImage image = wall();
  LabelImage labels{320, 240, std::vector<std::uint16_t>(image.depth.size(), 0)};
  for (int v = 60; v < 180; ++v)
    for (int u = 150; u < 162; ++u) labels.label[static_cast<std::size_t>(v) * 320 + u] = 1;
  SensorNoise noise;
  noise.inverse_depth_std = 2.5 * kStereo;
  EXPECT_TRUE(estimateSegments(image, labels, noise, {}).empty());
  noise.correlation_px = 12;
  EXPECT_EQ(estimateSegments(image, labels, noise, {}).size(), 1u);
}

}  // namespace
}  // namespace facetloc
