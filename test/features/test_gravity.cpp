// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/gravity.h>

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

namespace facetloc {
namespace {

TEST(Gravity, HasADirectionWhateverItsLength) {
  const Gravity gravity = gravityAlong({0, 9.81, 0}, kDegree);
  EXPECT_TRUE(gravity.down.isApprox(Eigen::Vector3d::UnitY()));
  EXPECT_EQ(gravity.std, kDegree);
  EXPECT_TRUE(gravity.valid());
}

TEST(Gravity, WithoutADirectionOrAnErrorIsRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(gravityAlong({0, 0, 0}, kDegree), std::invalid_argument);
  EXPECT_THROW(gravityAlong({0, nan, 0}, kDegree), std::invalid_argument);
  EXPECT_TRUE(gravityAlong({0, 1e308, 1e308}, kDegree).valid());
  for (const double std : {0.0, -1.0, nan, 2.0})
    EXPECT_THROW(gravityAlong({0, 1, 0}, std), std::invalid_argument) << std;
  EXPECT_FALSE((Gravity{{0, 2, 0}, kDegree}.valid()));
}

TEST(Gravity, LevelsACameraAndKeepsItsHeading) {
  for (const double tilt : {-60.0, -20.0, 0.0, 35.0, 70.0})
    for (const double roll : {-170.0, -90.0, -20.0, 0.0, 45.0, 90.0}) {
      // The level camera is rolled about its optical axis after it was tilted.
      const Eigen::Matrix3d R_level_c = expSO3({tilt * kDegree, 0, 0}) * expSO3({0, 0, roll * kDegree});
      const Eigen::Vector3d down = R_level_c.transpose() * Eigen::Vector3d::UnitY();
      EXPECT_TRUE(levelling(down).isApprox(R_level_c, 1e-9)) << tilt << " " << roll;
    }
}

TEST(Gravity, OfACameraThatLooksStraightDownKeepsTheHeadingOfItsUpperEdge) {
  for (const double tilt : {-90.0, -85.0, 85.0, 90.0}) {
    const Eigen::Matrix3d R_level_c = expSO3({tilt * kDegree, 0, 0});
    EXPECT_TRUE(levelling(R_level_c.transpose() * Eigen::Vector3d::UnitY()).isApprox(R_level_c, 1e-9))
        << tilt;
  }
}

}  // namespace
}  // namespace facetloc
