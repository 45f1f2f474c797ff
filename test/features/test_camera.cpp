// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/camera.h>
#include <facetloc/features/local_model.h>

#include <gmock/gmock.h>

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

}  // namespace
}  // namespace facetloc
