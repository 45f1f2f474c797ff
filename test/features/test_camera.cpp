// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/camera.h>
#include <facetloc/features/camera_presets.h>
#include <facetloc/features/lens_distortion.h>
#include <facetloc/features/local_model.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace facetloc {
namespace {

using testing::ElementsAre, testing::HasSubstr, testing::IsEmpty;
using Mounting = CameraDifference::Mounting;

Camera robotCamera() {
  Camera camera;
  camera.intrinsics = kinectIntrinsics();
  camera.mounting = CameraMounting{1, 10};
  return camera;
}

/** The same camera as a map knows it. */
Camera calibratedCamera() {
  Camera camera = robotCamera();
  camera.distortion.emplace(DepthDistortion::extentOf(camera.intrinsics));
  return camera;
}

std::vector<std::string> words(const Camera& of_view, const Camera& of_map, double noise_std = 0) {
  return toString(differenceOf(of_view, of_map, noise_std), of_view, of_map);
}

TEST(Camera, EqualCamerasNeedNoRemark) {
  const CameraDifference d = differenceOf(robotCamera(), robotCamera());
  EXPECT_TRUE(d.sameMounting());
  EXPECT_TRUE(d.same_optics);
  EXPECT_DOUBLE_EQ(d.noise_ratio, 1);
  EXPECT_THAT(words(robotCamera(), robotCamera()), IsEmpty());
  EXPECT_THAT(words(Camera(), Camera()), IsEmpty());
  EXPECT_THAT(words(robotCamera(), Camera()), IsEmpty());  // a map that says nothing uses nothing
}

TEST(Camera, MountingsAreTheSameToFiveCentimetresAndFiveDegrees) {
  Camera lower = robotCamera(), hand = robotCamera();
  lower.mounting->height = 0.97;
  EXPECT_TRUE(differenceOf(lower, robotCamera()).sameMounting());
  lower.mounting->height = 0.9;
  EXPECT_EQ(differenceOf(lower, robotCamera()).mounting, Mounting::other);
  EXPECT_THAT(
      words(lower, robotCamera()),
      ElementsAre(
          "the cameras are mounted differently, 0.900 m above the floor, 10.0 deg down, and in the map "
          "1.000 m above the floor, 10.0 deg down: the prior is isotropic, about the difference of both "
          "mountings"));
  hand.mounting.reset();
  EXPECT_EQ(differenceOf(hand, robotCamera()).mounting, Mounting::unknown);
  EXPECT_THAT(words(hand, robotCamera()),
              ElementsAre(HasSubstr("mounting of the images' camera is unknown")));
  EXPECT_EQ(differenceOf(robotCamera(), hand).mounting, Mounting::not_in_map);
}

TEST(Camera, ADistortionHoldsForTheSameOptics) {
  Camera other = robotCamera();
  other.intrinsics.fx *= 1.3;
  const CameraDifference d = differenceOf(other, calibratedCamera());
  EXPECT_FALSE(d.same_optics);
  EXPECT_FALSE(d.distortion_is_left_in);
  EXPECT_THAT(words(other, calibratedCamera()), ElementsAre(HasSubstr("other optics")));
  EXPECT_TRUE(differenceOf(robotCamera(), calibratedCamera()).distortion_is_left_in);
  EXPECT_THAT(words(robotCamera(), calibratedCamera()), ElementsAre(HasSubstr("was not taken out")));
  EXPECT_THAT(words(calibratedCamera(), calibratedCamera()), IsEmpty());
}

TEST(Camera, AMapLendsItsDistortionToACameraOfItsOptics) {
  Map map;
  map.camera = calibratedCamera();
  EXPECT_TRUE(map.calibrated(robotCamera()).distortion);
  EXPECT_TRUE(map.calibrated(Camera()).distortion);  // each image then tells whether it fits
  Camera other = robotCamera();
  other.intrinsics.fx *= 1.3;
  EXPECT_FALSE(map.calibrated(other).distortion);
  EXPECT_FALSE(Map().calibrated(robotCamera()).distortion);
  // Better known values stay.
  DepthDistortion::Values values{};
  values[0] = 0.001;
  Camera known = robotCamera();
  known.distortion.emplace(DepthDistortion::extentOf(known.intrinsics), values);
  EXPECT_EQ(map.calibrated(known).distortion->values()[0], 0.001);
}

TEST(Camera, ANoisierImageIsReported) {
  const double kinect = SensorNoise().inverse_depth_std;
  EXPECT_THAT(words(robotCamera(), robotCamera(), 1.2 * kinect), IsEmpty());
  EXPECT_THAT(words(robotCamera(), robotCamera(), 4 * kinect), ElementsAre(HasSubstr("4.0 times as noisy")));
  Camera noisy = robotCamera();
  noisy.noise.inverse_depth_std = 2 * kinect;
  EXPECT_THAT(words(noisy, robotCamera()), ElementsAre(HasSubstr("2.0 times as noisy")));
}

TEST(DepthNoise, IsTheSumOfItsPartsInDepthAndInInverseDepth) {
  DepthNoise noise;
  noise.inverse_depth_std = 0.001, noise.depth_std = 0.004, noise.depth_std_slope = 0.002;
  EXPECT_FALSE(noise.isConstantInInverseDepth());
  for (const double z : {0.3, 1.0, 2.0, 7.0}) {
    EXPECT_DOUBLE_EQ(noise.ofDepth(z), 0.004 + 0.002 * z + 0.001 * z * z);
    EXPECT_DOUBLE_EQ(noise.ofInverseDepth(z), noise.ofDepth(z) / (z * z)) << "to first order";
  }
  EXPECT_TRUE(DepthNoise().isConstantInInverseDepth());
  EXPECT_EQ(DepthNoise().ofInverseDepth(3), DepthNoise().inverse_depth_std) << "to the last digit";
}

TEST(DepthNoise, IsScaledAsAWhole) {
  DepthNoise noise;
  noise.depth_std = 0.004, noise.depth_std_slope = 0.002;
  const DepthNoise twice = noise.scaledTo(2 * noise.ofInverseDepth(1.7), 1.7);
  for (const double z : {0.5, 1.7, 4.0}) EXPECT_NEAR(twice.ofDepth(z), 2 * noise.ofDepth(z), 1e-12) << z;
  EXPECT_EQ(DepthNoise().scaledTo(0.007, 2.3).inverse_depth_std, 0.007) << "to the last digit";
}

TEST(CameraPresets, HaveNamesAndSoundNumbers) {
  std::set<std::string> names;
  for (const CameraPreset& preset : cameraPresets()) {
    EXPECT_TRUE(names.insert(preset.name).second) << preset.name;
    for (const Intrinsics& mode : preset.modes) EXPECT_TRUE(mode.valid()) << preset.name;
    EXPECT_GT(preset.min_depth, 0) << preset.name;
    EXPECT_GT(preset.max_depth, 1) << preset.name;
    EXPECT_EQ(findCameraPreset(preset.name), &preset);
    EXPECT_THAT(cameraPresetNames(), HasSubstr(preset.name));
    EXPECT_EQ(preset.camera().max_depth, preset.max_depth);
  }
  EXPECT_EQ(names,
            (std::set<std::string>{"kinect", "xtion", "realsense_d435", "azure_kinect", "phone_lidar"}));
}

TEST(CameraPresets, TheDefaultIsAKinect) {
  EXPECT_EQ(cameraPresets().front().name, std::string("kinect"));
  const Camera kinect = findCameraPreset("kinect")->camera(), usual;
  EXPECT_EQ(kinect.noise.inverse_depth_std, usual.noise.inverse_depth_std);
  EXPECT_EQ(kinect.max_depth, usual.max_depth);
  EXPECT_TRUE(std::isinf(usual.max_depth));
}

TEST(CameraPresets, KnowTheModesOfTheirDevices) {
  const CameraPreset& d435 = *findCameraPreset("realsense_d435");
  EXPECT_EQ(d435.intrinsicsOf(848, 480)->fx, 425);
  EXPECT_EQ(d435.intrinsicsOf(1280, 720)->fx, 640);
  EXPECT_EQ(d435.intrinsicsOf(320, 240)->fx, 192.5) << "of the mode of that shape";
  const Intrinsics upright = *d435.intrinsicsOf(480, 848);
  EXPECT_EQ(upright.fx, 425);
  EXPECT_EQ(upright.cx, 239.5);
  EXPECT_EQ(upright.cy, 423.5);
  EXPECT_FALSE(d435.intrinsicsOf(640, 576));
  EXPECT_EQ(findCameraPreset("phone_lidar")->intrinsicsOf(192, 256)->height, 256);
}

TEST(CameraPresets, AreFoundByTheSizeOfTheirImages) {
  const auto name = [](int width, int height) { return std::string(cameraPresetFor(width, height).name); };
  EXPECT_EQ(name(640, 480), "kinect");
  EXPECT_EQ(name(848, 480), "realsense_d435");
  EXPECT_EQ(name(720, 1280), "realsense_d435");
  EXPECT_EQ(name(512, 512), "azure_kinect");
  EXPECT_EQ(name(192, 256), "phone_lidar");
  EXPECT_EQ(name(320, 180), "realsense_d435") << "no mode, but the shape of one";
  EXPECT_EQ(name(333, 100), "kinect");
}

TEST(CameraPresets, UnknownNamesHaveNone) {
  for (const char* name : {"", "Kinect", "kinect ", "kinect2"})
    EXPECT_EQ(findCameraPreset(name), nullptr) << name;
}

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
