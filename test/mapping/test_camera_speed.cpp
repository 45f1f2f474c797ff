// SPDX-License-Identifier: BSD-3-Clause
#include "trajectory/camera_speed.h"

#include <gtest/gtest.h>

namespace facetloc {

using namespace internal;

namespace {

Eigen::Isometry3d along(double x) { return Eigen::Isometry3d(Eigen::Translation3d(x, 0, 0)); }

CameraSpeed after(int images, double interval) {
  CameraSpeed speed;
  for (int i = 0; i < images; ++i) speed.addInterval(interval);
  return speed;
}

TEST(CameraSpeed, AHoleInAVideoIsAGap) {
  const CameraSpeed speed = after(50, 0.033);
  EXPECT_TRUE(speed.isGap(3.5));
  EXPECT_FALSE(speed.isGap(0.1)) << "a few lost images";
}

TEST(CameraSpeed, AnImageNowAndThenIsARhythm) {
  EXPECT_FALSE(after(0, 0).isGap(5));
  EXPECT_FALSE(after(5, 5).isGap(6));
  EXPECT_TRUE(after(5, 5).isGap(20));
}

TEST(CameraSpeed, AFastCameraIsGoneSooner) {
  CameraSpeed speed = after(50, 0.033);
  EXPECT_FALSE(speed.isGap(0.8));
  speed.addMotion(along(0.75), 0.5);
  EXPECT_TRUE(speed.isGap(0.8));
  EXPECT_NEAR(speed.farthest(2), 6, 1e-9);
}

TEST(CameraSpeed, NoiseOfAnInstantIsNoSpeed) {
  CameraSpeed speed;
  speed.addMotion(along(0.1), 0.01);
  EXPECT_NEAR(speed.farthest(1), 1.5, 1e-9);
}

}  // namespace
}  // namespace facetloc
