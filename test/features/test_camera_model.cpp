// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/camera_model.h>
#include <facetloc/features/pose.h>
#include <facetloc/testing/matchers.h>
#include <facetloc/testing/numeric_jacobian.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/random_segments.h>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace facetloc {
namespace {

using test::IsPositiveSemidefinite, test::MatrixNear, test::Rng, test::uniform;

// The point of a raw Kinect measurement (u, v, disparity), METHOD 2.1.
Eigen::Vector3d kinectPoint(const Intrinsics& c, const Eigen::Vector3d& uvd) {
  return kinectDepth(uvd[2]) * c.ray(uvd[0], uvd[1]);
}

TEST(CameraModel, DisparityAndDepthAreInverse) {
  for (double z = 0.4; z < 10; z += 0.1) EXPECT_NEAR(kinectDepth(kinectDisparity(z)), z, 1e-12 * z);
  EXPECT_GT(kinectDisparity(2.0), kinectDisparity(1.0));
}

TEST(CameraModel, OneDisparityUnitMatchesTheTableOfTheMethod) {
  const double millimetres[] = {2.8, 11.4, 25.6, 45.6, 71.2};
  for (int z = 1; z <= 5; ++z) {
    const double d = kinectDisparity(z);
    EXPECT_NEAR(500 * (kinectDepth(d + 1) - kinectDepth(d - 1)), millimetres[z - 1], 0.06) << z;
  }
}

TEST(CameraModel, ProjectionInvertsTheRay) {
  const Intrinsics c = kinectIntrinsics();
  Rng rng(1);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector2d pixel{uniform(rng, -50, 700), uniform(rng, -50, 500)};
    EXPECT_THAT(c.project(uniform(rng, 0.1, 10) * c.ray(pixel.x(), pixel.y())), MatrixNear(pixel, 1e-10));
  }
}

TEST(CameraModel, PointCovarianceIsThatOfTheDisparityModel) {
  const Intrinsics c = kinectIntrinsics();
  Rng rng(2);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d uvd{uniform(rng, 0, 640), uniform(rng, 0, 480),
                              kinectDisparity(uniform(rng, 0.5, 6))};
    const double sigma_pixel = uniform(rng, 0.1, 2), sigma_d = uniform(rng, 0.1, 2);
    const auto J =
        test::numericJacobian<3, 3>([&](const Eigen::Vector3d& x) { return kinectPoint(c, x); }, uvd, 3e-4);
    const Eigen::Vector3d variance(sigma_pixel * sigma_pixel, sigma_pixel * sigma_pixel, sigma_d * sigma_d);
    const Eigen::Matrix3d numeric = J * variance.asDiagonal() * J.transpose();
    const Eigen::Matrix3d closed =
        pointCovariance(kinectPoint(c, uvd), c, sigma_pixel, sigma_d / kKinectGain);
    EXPECT_LT((closed - numeric).norm() / numeric.norm(), 1e-9);  // worst observed: 4e-10, of the differences
    EXPECT_THAT(closed, IsPositiveSemidefinite(1e-15));
    EXPECT_GT(closed.determinant(), 0);
  }
}

TEST(CameraModel, DistantPointsAreUncertainAlongTheirRay) {
  const Intrinsics c = kinectIntrinsics();
  constexpr double kPixelStd = 0.3;  // [px]
  Rng rng(3);
  double worst = 0;
  for (int i = 0; i < 500; ++i) {
    // At 1 m the pixel errors are not small beside the depth error; from 2 m on they are.
    const Eigen::Vector3d p = uniform(rng, 2, 6) * c.ray(uniform(rng, 0, 640), uniform(rng, 0, 480));
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eig(
        pointCovariance(p, c, kPixelStd, SensorNoise().inverse_depth_std));
    worst = std::max(worst, eig.eigenvectors().col(2).cross(p.normalized()).norm());
  }
  EXPECT_LT(worst, std::sin(1 * kDegree));  // worst observed: 0.8 deg
}

TEST(CameraModel, DefaultNoiseIsHalfADisparityUnit) {
  const Eigen::Matrix3d S =
      pointCovariance({0, 0, 3}, kinectIntrinsics(), 0, SensorNoise{}.inverse_depth_std);
  const double sigma_z =
      0.5 * (kinectDepth(kinectDisparity(3) + 0.5) - kinectDepth(kinectDisparity(3) - 0.5));
  EXPECT_NEAR(std::sqrt(S(2, 2)), sigma_z, 1e-6);
}

TEST(CameraModel, SubsampledPixelsKeepTheirRays) {
  const Intrinsics full{641, 479, 585, 580, 318.5, 256.25};
  for (const int step : {1, 2, 3, 4}) {
    const Intrinsics small = full.subsampled(step);
    EXPECT_EQ(small.width, (full.width - 1) / step + 1);
    EXPECT_EQ(small.height, (full.height - 1) / step + 1);
    for (const int u : {0, 1, small.width - 1})
      for (const int v : {0, 7, small.height - 1})
        EXPECT_THAT(small.ray(u, v), MatrixNear(full.ray(step * u, step * v), 1e-15)) << step;
  }
  EXPECT_EQ(full.subsampled(1), full);
}

TEST(CameraModel, ImpossibleIntrinsicsAreNotValid) {
  const Intrinsics good = kinectIntrinsics();
  EXPECT_TRUE(good.valid());
  EXPECT_FALSE(Intrinsics{}.valid());
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const double bad : {0.0, -500.0, nan, inf}) {
    Intrinsics c = good;
    c.fx = bad;
    EXPECT_FALSE(c.valid()) << bad;
    c = good;
    c.fy = bad;
    EXPECT_FALSE(c.valid()) << bad;
  }
  for (const double bad : {nan, inf, -inf}) {
    Intrinsics c = good;
    c.cx = bad;
    EXPECT_FALSE(c.valid()) << bad;
    c = good;
    c.cy = bad;
    EXPECT_FALSE(c.valid()) << bad;
  }
  Intrinsics c = good;
  c.height = 0;
  EXPECT_FALSE(c.valid());
}

TEST(CameraModel, NoiseOutsideItsRangeIsNamed) {
  SensorNoise noise;
  EXPECT_NO_THROW(checkRanges(noise));
  noise.distortion_slope = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(test::messageOf<std::invalid_argument>([&] { checkRanges(noise); }),
              testing::HasSubstr("distortion_slope"));
}

TEST(CameraMounting, ALevelCameraLooksForward) {
  const Eigen::Isometry3d T = CameraMounting{0.98, 0}.T_b_c();
  EXPECT_THAT((T.linear() * Eigen::Vector3d::UnitX()).eval(), MatrixNear(-Eigen::Vector3d::UnitY(), 1e-15));
  EXPECT_THAT((T.linear() * Eigen::Vector3d::UnitY()).eval(), MatrixNear(-Eigen::Vector3d::UnitZ(), 1e-15));
  EXPECT_THAT((T.linear() * Eigen::Vector3d::UnitZ()).eval(), MatrixNear(Eigen::Vector3d::UnitX(), 1e-15));
  EXPECT_THAT(T.translation(), MatrixNear(Eigen::Vector3d(0, 0, 0.98), 0));
}

TEST(CameraMounting, PanTurnsToTheLeftAndTheBaseIsBehind) {
  CameraMounting mounting{1, 0};
  mounting.pan_deg = 90, mounting.x = 0.3, mounting.y = -0.1;
  const Eigen::Isometry3d T = mounting.T_b_c();
  EXPECT_THAT((T.linear() * Eigen::Vector3d::UnitZ()).eval(), MatrixNear(Eigen::Vector3d::UnitY(), 1e-15));
  EXPECT_THAT((T.linear() * Eigen::Vector3d::UnitX()).eval(), MatrixNear(Eigen::Vector3d::UnitX(), 1e-15));
  EXPECT_THAT(T.translation(), MatrixNear(Eigen::Vector3d(0.3, -0.1, 1), 0));
}

TEST(CameraMounting, RollLowersTheRightSideOfTheImage) {
  CameraMounting mounting{1, 0};
  mounting.roll_deg = 30;
  const Eigen::Isometry3d T = mounting.T_b_c();
  EXPECT_THAT((T.linear() * Eigen::Vector3d::UnitZ()).eval(), MatrixNear(Eigen::Vector3d::UnitX(), 1e-15));
  EXPECT_NEAR((T.linear() * Eigen::Vector3d::UnitX()).z(), -0.5, 1e-12);
}

TEST(CameraMounting, TheFloorFixesTiltAndRollForAnyPan) {
  for (const double pan : {0.0, 40.0, -170.0}) {
    CameraMounting mounting{1, 25};
    mounting.roll_deg = -12, mounting.pan_deg = pan, mounting.x = 1;
    const Eigen::Vector3d down = -(mounting.T_b_c().linear().transpose() * Eigen::Vector3d::UnitZ());
    EXPECT_NEAR(std::asin(down.z()) / kDegree, 25, 1e-9);
    EXPECT_NEAR(std::atan2(down.x(), down.y()) / kDegree, -12, 1e-9);
  }
}

TEST(CameraMounting, AgreesAsWellAsMountingsAreMeasured) {
  const CameraMounting mounting{1, 10};
  EXPECT_TRUE(mounting.agreesWith({1.04, 7}));
  EXPECT_FALSE(mounting.agreesWith({0.9, 10}));
  EXPECT_FALSE(mounting.agreesWith({1, 20}));
  EXPECT_TRUE(mounting.agreesWith({1, 10, 4}));
  EXPECT_FALSE(mounting.agreesWith({1, 10, 8}));
  EXPECT_TRUE(mounting.agreesWith({1, 10, 0, 90, 2, 1})) << "of which the floor tells nothing";
}

TEST(CameraMounting, TiltTurnsTheOpticalAxisDownwards) {
  const Eigen::Isometry3d T = CameraMounting{1.2, 20}.T_b_c();
  const Eigen::Vector3d axis(std::cos(20 * kDegree), 0, -std::sin(20 * kDegree));
  EXPECT_THAT(T.linear().col(2), MatrixNear(axis, 1e-15));
  EXPECT_THAT(T.linear().col(0), MatrixNear(-Eigen::Vector3d::UnitY(), 1e-15));  // the image stays level
  EXPECT_THAT(Eigen::Matrix3d(T.linear()), test::IsRotation());
}

}  // namespace
}  // namespace facetloc
