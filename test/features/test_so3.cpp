// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/gravity.h>
#include <facetloc/features/pose.h>
#include <facetloc/testing/numeric_jacobian.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/random_segments.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace facetloc {
namespace {

using test::gaussian, test::IsRotation, test::MatrixNear, test::PoseNear, test::randomDirection, test::Rng;

constexpr double kPi = 3.14159265358979323846;

// Zero, around the switch-over points of the series, moderate, and nearly half a turn.
const double kAngles[] = {0, 1e-12, 1e-9, 1.1e-9, 1e-8, 0.99e-5, 1.01e-5, 1e-3, 0.1, 1, 2.5, kPi - 1e-6};

TEST(So3, SkewIsTheCrossProduct) {
  Rng rng(1);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d a = gaussian<3>(rng), b = gaussian<3>(rng);
    EXPECT_THAT((skew(a) * b).eval(), MatrixNear(a.cross(b), 1e-15));
  }
}

TEST(So3, ExpIsARotationAndLogItsInverse) {
  Rng rng(2);
  for (const double angle : kAngles)
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector3d phi = angle * randomDirection(rng);
      const Eigen::Matrix3d R = expSO3(phi);
      EXPECT_THAT(R, IsRotation()) << angle;
      EXPECT_THAT(logSO3(R), MatrixNear(phi, 1e-14 + 1e-9 * angle)) << angle;
      EXPECT_THAT(expSO3(-phi), MatrixNear(R.transpose(), 1e-15)) << angle;
    }
}

TEST(So3, ExpAgreesWithItsPowerSeries) {
  Rng rng(3);
  for (const double angle : {1e-8, 1e-3, 0.1, 1.0}) {
    const Eigen::Matrix3d K = skew(angle * randomDirection(rng));
    Eigen::Matrix3d sum = Eigen::Matrix3d::Identity(), term = sum;
    for (int k = 1; k < 25; ++k) sum += term = (term * K / k).eval();
    EXPECT_THAT(expSO3({K(2, 1), K(0, 2), K(1, 0)}), MatrixNear(sum, 1e-15));
  }
}

TEST(So3, HalfATurnComesBackUpToTheSignOfItsAxis) {
  Rng rng(4);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Matrix3d R = expSO3(kPi * randomDirection(rng));
    EXPECT_NEAR(logSO3(R).norm(), kPi, 1e-9);
    EXPECT_THAT(expSO3(logSO3(R)), MatrixNear(R, 1e-12));
  }
}

TEST(So3, LeftJacobianIsTheDerivativeOfExp) {
  Rng rng(5);
  for (const double angle : kAngles)
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector3d phi = angle * randomDirection(rng);
      const auto displaced = [&](const Eigen::Vector3d& d) {
        return logSO3(expSO3(phi + d) * expSO3(phi).transpose());
      };
      const Eigen::Matrix3d J = test::numericJacobian<3, 3>(displaced, Eigen::Vector3d::Zero().eval());
      EXPECT_THAT(leftJacobianSO3(phi), MatrixNear(J, 1e-9)) << angle;
    }
}

TEST(So3, LeftJacobianKeepsItsAxisAndIsTheRightOneTurned) {
  Rng rng(6);
  for (const double angle : kAngles) {
    const Eigen::Vector3d phi = angle * randomDirection(rng);
    EXPECT_THAT((leftJacobianSO3(phi) * phi).eval(), MatrixNear(phi, 1e-14)) << angle;
    EXPECT_THAT((expSO3(phi) * leftJacobianSO3(-phi)).eval(), MatrixNear(leftJacobianSO3(phi), 1e-10))
        << angle;
  }
}

TEST(So3, RotationAngleIsAccurateNearZero) {
  Rng rng(7);
  for (const double angle : kAngles)
    EXPECT_NEAR(rotationAngle(expSO3(angle * randomDirection(rng))), angle, 1e-15 + 1e-9 * angle);
}

TEST(So3, RotationBetweenTurnsOneDirectionIntoAnotherByTheAngleBetweenThem) {
  Rng rng(10);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d from = randomDirection(rng), to = randomDirection(rng);
    const Eigen::Matrix3d R = rotationBetween(from, 3 * to);
    EXPECT_THAT(R, IsRotation());
    EXPECT_THAT((R * from).eval(), MatrixNear(to, 1e-12));
    EXPECT_NEAR(rotationAngle(R), std::acos(from.dot(to)), 1e-6);
    const Eigen::Matrix3d back = rotationBetween(from, -from);
    EXPECT_THAT(back, IsRotation());
    EXPECT_THAT((back * from).eval(), MatrixNear(-from, 1e-6));
  }
}

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
