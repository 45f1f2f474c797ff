// SPDX-License-Identifier: BSD-3-Clause
#include "inputs/localization_options.h"

#include <facetloc/testing/pose_matchers.h>

#include <gtest/gtest.h>

#include <cmath>

namespace facetloc::test {
namespace {

TEST(StartPose, LooksTowardsItsHeading) {
  const auto start = startPose("1,2,1.2,90", {});
  ASSERT_TRUE(start);
  EXPECT_TRUE(start->T.translation().isApprox(Eigen::Vector3d(1, 2, 1.2)));
  EXPECT_TRUE(start->T.linear().col(2).isApprox(Eigen::Vector3d::UnitY(), 1e-9)) << "the optical axis";
  EXPECT_TRUE(start->T.linear().col(1).isApprox(-Eigen::Vector3d::UnitZ(), 1e-9)) << "down in the image";
  EXPECT_NEAR(largestTranslationStd(start->P), 1, 1e-9);
  EXPECT_NEAR(largestRotationStd(start->P), 30 * kDegree, 1e-9);
}

TEST(StartPose, IsMountedAsTheCamera) {
  CameraMounting mounting;
  mounting.height = 1.2, mounting.tilt_deg = 20, mounting.pan_deg = 35;
  const auto start = startPose("0,0,1.2,0,0.3,5", mounting);
  ASSERT_TRUE(start);
  const Eigen::Vector3d axis = start->T.linear().col(2);
  EXPECT_NEAR(std::atan2(axis.y(), axis.x()), 0, 1e-9) << "whatever its pan";
  EXPECT_NEAR(axis.z(), -std::sin(20 * kDegree), 1e-9);
  EXPECT_NEAR(largestTranslationStd(start->P), 0.3, 1e-9);
}

TEST(StartPose, RefusesInvalidText) {
  EXPECT_FALSE(startPose("", {}));
  for (const char* text : {"1", "1,2,3", "1,2,3,4,5,6,7", "a,2,3,4", "1,2,3,nan", "1,2,3,4,0", "1,2,3,4,-1",
                           "1,2,3,4,1,0", "1,2,3,4,1,181", "1,2,3,4,1e200", "1,2,,4", "1;2;3;4"})
    EXPECT_THROW(startPose(text, {}), UsageError) << text;
}

}  // namespace
}  // namespace facetloc::test
