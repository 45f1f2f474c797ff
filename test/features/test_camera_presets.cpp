// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/camera_presets.h>

#include <gmock/gmock.h>

#include <cmath>
#include <set>
#include <string>

namespace facetloc {
namespace {

using testing::HasSubstr;

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

}  // namespace
}  // namespace facetloc
