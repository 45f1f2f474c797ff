// SPDX-License-Identifier: BSD-3-Clause
//
// The errors of each simulated camera, as statistics of its images.
#include "simulated_walls.h"

#include <facetloc/features/camera_presets.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

namespace facetloc {
namespace {

using test::kCamera, test::noErrors, test::wallAt;

DepthImage seen(const SimulatedNoise& noise, const std::vector<Rectangle>& rectangles, int frame = 0) {
  return test::rendered(noise, rectangles, frame).depth;
}

double measuredShare(const DepthImage& image) {
  return static_cast<double>(
             std::count_if(image.depth.begin(), image.depth.end(), [](float z) { return z > 0; })) /
         static_cast<double>(image.depth.size());
}

/** As in features/SENSORS.md. */
DepthNoise noiseInTable(const std::string& name) {
  DepthNoise noise;
  if (name == "realsense_d435") noise.inverse_depth_std = 0.0030;
  if (name == "azure_kinect")
    noise.inverse_depth_std = 1e-4, noise.depth_std = 5e-4, noise.depth_std_slope = 5e-4;
  if (name == "phone_lidar")
    noise.inverse_depth_std = 1e-4, noise.depth_std = 2e-3, noise.depth_std_slope = 2e-3;
  return noise;
}

TEST(SimulatedPresets, HaveTheNoiseOfTheirTable) {
  for (const CameraPreset& preset : cameraPresets()) {
    SimulatedNoise noise = simulatedNoise(preset.name);
    noise.distortion = 0;
    for (const double z : {1.0, 2.0, 4.0}) {
      double squares = 0, n = 0;
      for (int frame = 0; frame < 4; ++frame)
        for (const float depth : seen(noise, {wallAt(z)}, frame).depth)
          if (depth > 0) squares += (depth - z) * (depth - z), n += 1;
      ASSERT_GT(n, 0.5 * 4 * 320 * 240) << preset.name;
      // A Kinect's rounding comes on top of its noise: sqrt(0.5^2 + 1/12) of its 0.5 units.
      const double expected = noiseInTable(preset.name).ofDepth(z) * (noise.quantization > 0 ? 1.155 : 1);
      const double tolerance = preset.name == std::string("xtion") ? 0.12 : 0.1;
      EXPECT_NEAR(std::sqrt(squares / n) / expected, 1, tolerance) << preset.name << " at " << z << " m";
    }
  }
}

TEST(SimulatedPresets, OfAKinectAreTheDefault) {
  for (const char* name : {"kinect", "xtion"})
    EXPECT_EQ(seen(simulatedNoise(name), {wallAt(2), wallAt(1, 0.2, 2)}).depth,
              seen(SimulatedNoise(), {wallAt(2), wallAt(1, 0.2, 2)}).depth);
  EXPECT_THROW(simulatedNoise("nikon"), std::invalid_argument);
}

TEST(SimulatedPresets, NoiseOfStereoIsSmooth) {
  SimulatedNoise noise = simulatedNoise("realsense_d435");
  noise.distortion = 0;
  const DepthImage image = seen(noise, {wallAt(1)});
  double products = 0, squares = 0;
  for (std::size_t i = 0; i + 2 < image.depth.size(); ++i) {
    const double a = image.depth[i], b = image.depth[i + 2];
    if (!(a > 0 && b > 0)) continue;
    products += (a - 1) * (b - 1);
    squares += (a - 1) * (a - 1);
  }
  // 5 px at 640 columns are 2.5 at 320: exp(-2^2 / (4 * 2.5^2)).
  EXPECT_NEAR(products / squares, std::exp(-0.16), 0.05);
}

TEST(SimulatedCamera, StereoFattensNearSurfaces) {
  SimulatedNoise noise = noErrors();
  noise.fattening_px = 8;  // 4 at this size
  const std::vector<Rectangle> scene = {wallAt(3), wallAt(1, 0.2, 2)};
  const DepthImage exact = seen(noErrors(), scene), fat = seen(noise, scene);
  const auto widthOf = [](const DepthImage& image) {
    int n = 0;
    for (int u = 0; u < 320; ++u) n += std::abs(image.at(u, 120) - 1) < 1e-4;
    return n;
  };
  EXPECT_EQ(widthOf(fat), widthOf(exact) + 2 * 4);
}

TEST(SimulatedCamera, StereoMissesSurfacesWithoutTexture) {
  SimulatedNoise noise = noErrors();
  noise.untextured = 0.3;
  const DepthImage image = seen(noise, {wallAt(2)});
  EXPECT_NEAR(measuredShare(image), 0.7, 0.01);
  int borders = 0;
  for (int u = 0; u + 1 < 320; ++u) borders += (image.at(u, 120) > 0) != (image.at(u + 1, 120) > 0);
  EXPECT_LT(borders, 60) << "in patches: at random it would be 134 of 319";
}

TEST(SimulatedCamera, FlyingPixelsLieBetweenTwoSurfaces) {
  SimulatedNoise noise = noErrors();
  noise.flying_px = 2;
  const DepthImage image = seen(noise, {wallAt(3), wallAt(1, 0.2, 2)});
  int flying = 0;
  for (int v = 0; v < 240; ++v)
    for (int u = 0; u < 320; ++u) {
      const float z = image.at(u, v);
      ASSERT_TRUE(z > 1 - 1e-5 && z < 3 + 1e-5);
      if (z < 1.001 || z > 2.999) continue;
      ++flying;
      const Eigen::Vector3d p = kCamera.ray(u, v);
      ASSERT_LT(std::abs(std::max(std::abs(p.x()), std::abs(p.y())) - 0.2) * kCamera.fx, 6)
          << "at the silhouette";
    }
  EXPECT_GT(flying, 100);
  EXPECT_LT(flying, 2000);
}

TEST(SimulatedCamera, MultipathMovesTheInsideOfACornerAway) {
  SimulatedNoise noise = noErrors();
  noise.multipath = 0.02;
  Rectangle side;  // meets the wall at x = 0.5
  side.centre = {0.5, 0, 1};
  side.axis_u = Eigen::Vector3d::UnitY();
  side.axis_v = Eigen::Vector3d::UnitZ();
  side.half_u = 100, side.half_v = 1, side.plane_id = 2;
  const DepthImage image = seen(noise, {wallAt(2), side});
  const auto errorAt = [&](double x) {
    return image.at(static_cast<int>(std::lround(kCamera.cx + kCamera.fx * x / 2)), 120) - 2;
  };
  EXPECT_GT(errorAt(0.45), 0.01);
  EXPECT_LT(errorAt(0.45), 0.02);
  EXPECT_NEAR(errorAt(-0.3), 0, 1e-5) << "far from the corner";
  // A step is no corner that light could come round by way of the farther surface.
  const DepthImage step = seen(noise, {wallAt(3), wallAt(1, 0.2, 2)});
  EXPECT_NEAR(step.at(160, 120), 1, 1e-5);
  EXPECT_NEAR(step.at(110, 120), 1, 1e-5);
}

TEST(SimulatedCamera, DepthsBeyondTheReliableRangeAreTooSmall) {
  SimulatedNoise noise = noErrors();
  noise.reliable_depth = 5;
  EXPECT_NEAR(seen(noise, {wallAt(4.9)}).at(160, 120), 4.9, 1e-4);
  EXPECT_NEAR(seen(noise, {wallAt(7)}).at(160, 120), 6, 1e-4);
}

// ---- Errors that pixels share ----

double correlation(const DepthImage& a, const DepthImage& b, double z) {
  double ab = 0, aa = 0, bb = 0;
  for (std::size_t i = 0; i < a.depth.size(); ++i) {
    const double x = a.depth[i] - z, y = b.depth[i] - z;
    ab += x * y, aa += x * x, bb += y * y;
  }
  return ab / std::sqrt(aa * bb);
}

TEST(SharedErrors, ArePartOfACameraOnlyIfAskedFor) {
  for (const CameraPreset& preset : cameraPresets()) {
    const SimulatedNoise usual = simulatedNoise(preset.name);
    EXPECT_EQ(usual.smooth_error, 0) << preset.name;
    EXPECT_EQ(usual.blur_px, 0) << preset.name;
    EXPECT_EQ(usual.filling_px, 0) << preset.name;
    EXPECT_GT(simulatedNoise(preset.name, SharedErrors::as_measured).smooth_error, 0) << preset.name;
  }
  EXPECT_GT(simulatedNoise("realsense_d435", SharedErrors::as_measured).blur_px, 0);
  EXPECT_GT(simulatedNoise("phone_lidar", SharedErrors::as_measured).filling_px, 0);
}

TEST(SharedErrors, SmoothErrorIsAShareOfDepthThatNoMeanIsFreeOf) {
  SimulatedNoise noise = noErrors();
  noise.smooth_error = 0.01, noise.smooth_images = 1;
  double squares = 0, of_blocks = 0;
  constexpr int kFrames = 40, kBlock = 40;
  for (int frame = 0; frame < kFrames; ++frame) {
    const DepthImage image = seen(noise, {wallAt(2)}, frame);
    for (const float z : image.depth) squares += std::pow(z / 2 - 1, 2) / (320 * 240 * kFrames);
    double block = 0;
    for (int v = 0; v < kBlock; ++v)
      for (int u = 0; u < kBlock; ++u) block += (image.at(u, v) / 2 - 1) / (kBlock * kBlock);
    of_blocks += block * block / kFrames;
  }
  EXPECT_NEAR(std::sqrt(squares), 0.01, 0.0005);
  EXPECT_GT(std::sqrt(of_blocks), 0.007) << "1600 independent pixels would leave 0.00025";
}

TEST(SharedErrors, SmoothErrorChangesSlowlyFromImageToImage) {
  SimulatedNoise noise = noErrors();
  noise.smooth_error = 0.01, noise.smooth_images = 10;
  const DepthImage first = seen(noise, {wallAt(2)}, 0);
  EXPECT_GT(correlation(first, seen(noise, {wallAt(2)}, 1), 2), 0.9);
  double far = 0;
  for (int k = 2; k < 18; ++k) far += std::abs(correlation(first, seen(noise, {wallAt(2)}, 10 * k), 2)) / 16;
  EXPECT_LT(far, 0.5);
}

TEST(SharedErrors, BlurMakesRampsOfSilhouettesAndLeavesPlanes) {
  SimulatedNoise noise = noErrors();
  noise.blur_px = 4;  // 2 at this size
  Rectangle slope = wallAt(3);
  slope.axis_u = Eigen::Vector3d(1, 0, 0.5).normalized();
  const DepthImage exact = seen(noErrors(), {slope}), same = seen(noise, {slope});
  for (int u = 20; u < 300; ++u) EXPECT_NEAR(same.at(u, 120), exact.at(u, 120), 1e-4) << u;
  const std::vector<Rectangle> step = {wallAt(3), wallAt(1, 0.2, 2)};
  const DepthImage sharp = seen(noErrors(), step), ramp = seen(noise, step);
  int between = 0;
  for (int u = 0; u < 320; ++u) between += ramp.at(u, 120) > 1.02 && ramp.at(u, 120) < 2.9;
  EXPECT_GE(between, 2 * 4);
  EXPECT_LE(between, 2 * 12);
  for (int u = 0; u < 320; ++u) {
    const double x = std::abs(u - kCamera.cx);
    if (std::abs(x - 0.2 * kCamera.fx) < 10) continue;
    EXPECT_NEAR(ramp.at(u, 120), sharp.at(u, 120), 1e-3) << u;
  }
}

TEST(SharedErrors, FillingLeavesNoHoleAndInterpolatesEdges) {
  SimulatedNoise noise = noErrors();
  noise.untextured = 0.3;  // holes
  noise.filling_px = 12;   // 6 at this size
  const std::vector<Rectangle> step = {wallAt(3), wallAt(1, 0.2, 2)};
  const DepthImage image = seen(noise, step);
  EXPECT_EQ(measuredShare(image), 1);
  const double edge = kCamera.cx + 0.2 * kCamera.fx;  // edge of the near wall
  EXPECT_GT(image.at(static_cast<int>(edge) - 1, 120), 1.05);
  EXPECT_LT(image.at(static_cast<int>(edge) + 2, 120), 2.9);
  SimulatedNoise without_holes = noise;
  without_holes.untextured = 0;
  const DepthImage whole = seen(without_holes, step);
  for (int u = 0; u < 320; ++u) {
    const double x = std::abs(u - kCamera.cx);
    if (std::abs(x - 0.2 * kCamera.fx) < 8) continue;
    EXPECT_NEAR(whole.at(u, 120), x < 0.2 * kCamera.fx ? 1 : 3, 1e-4) << u;
  }
}

TEST(SharedErrors, FillingMakesNothingUpWhereNothingIsSeen) {
  SimulatedNoise noise = noErrors();
  noise.filling_px = 12;
  EXPECT_EQ(measuredShare(seen(noise, {})), 0);
}

}  // namespace
}  // namespace facetloc
