// SPDX-License-Identifier: BSD-3-Clause
#include "depth/depth_consistency.h"

#include <facetloc/features/camera_model.h>
#include <facetloc/testing/random_segments.h>
#include <facetloc/testing/synthetic_depth.h>

#include <gtest/gtest.h>

#include <cmath>

namespace facetloc {
namespace {

using namespace internal;
using test::endlessPlane, test::lookingAlong, test::render, test::smallCamera;

const Eigen::Isometry3d kHere = Eigen::Isometry3d::Identity();

DepthComparison comparison() { return DepthComparison({}); }

DepthPicture wallAt(double z, const Eigen::Vector3d& normal = Eigen::Vector3d::UnitZ()) {
  return DepthPicture::fromDepth(render({endlessPlane({0, 0, z}, normal)}, smallCamera()).image);
}

DepthPicture roomFrom(const Eigen::Isometry3d& T_w_c) {
  return DepthPicture::fromDepth(render(test::furnishedRoom(), smallCamera(), T_w_c).image);
}

/** Pixels that agree, that contradict, and that are occluded. */
Eigen::Vector3i countsOf(const DepthAgreement& a) { return {a.agree, a.contradict, a.occluded}; }

int pixelsOfGrid(const DepthPicture& p, int columns) {
  const int step = gridStep(p, columns);
  return ((p.camera.width - step / 2 - 1) / step + 1) * ((p.camera.height - step / 2 - 1) / step + 1);
}

TEST(DepthConsistency, APictureAgreesWithItselfEverywhere) {
  const DepthPicture p = roomFrom(lookingAlong({1, 0.5, 1.2}, {0.4, 1, -0.2}));
  for (const int columns : {kCoarseColumns, kFineColumns}) {
    const DepthAgreement a = comparison().compare(p, p, kHere, columns);
    EXPECT_EQ(a.contradict, 0);
    EXPECT_EQ(a.occluded, 0);
    EXPECT_EQ(a.agree, pixelsOfGrid(p, columns));
    EXPECT_EQ(a.net(), a.agree);
  }
}

TEST(DepthConsistency, AWallPredictedNearerThanMeasuredContradicts) {
  // a sees a wall at 2 m; the other camera, at the same place, looked through it to 3 m.
  const DepthAgreement a = comparison().compare(wallAt(2), wallAt(3), kHere, kFineColumns);
  EXPECT_EQ(a.agree + a.occluded, 0);
  EXPECT_EQ(a.contradict, pixelsOfGrid(wallAt(2), kFineColumns));
  EXPECT_EQ(a.net(), -5 * a.contradict);
}

TEST(DepthConsistency, AWallPredictedFartherThanMeasuredIsOccluded) {
  const DepthAgreement a = comparison().compare(wallAt(3), wallAt(2), kHere, kFineColumns);
  EXPECT_EQ(a.agree + a.contradict, 0);
  EXPECT_EQ(a.occluded, pixelsOfGrid(wallAt(3), kFineColumns));
}

TEST(DepthConsistency, MovingTheCameraExplainsTheDifference) {
  Eigen::Isometry3d T = kHere;
  T.translation().z() = 1;  // a stands one metre nearer to the wall
  const DepthAgreement a = comparison().compare(wallAt(2), wallAt(3), T, kFineColumns);
  EXPECT_EQ(a.contradict + a.occluded, 0);
  EXPECT_GT(a.agree, 0);
}

TEST(DepthConsistency, BothDirectionsAreTheSumOfEach) {
  const Eigen::Isometry3d A = lookingAlong({1, 0.5, 1.2}, {0.4, 1, -0.2}),
                          B = lookingAlong({1.4, 0.8, 1.3}, {0.2, 1, -0.1});
  const DepthPicture a = roomFrom(A), b = roomFrom(B);
  Eigen::Isometry3d T = B.inverse() * A;
  T.translation().x() += 0.1;
  const DepthAgreement there = comparison().compare(a, b, T, kFineColumns),
                       back = comparison().compare(b, a, T.inverse(), kFineColumns),
                       both = comparison().compareBoth(a, b, T, kFineColumns),
                       swapped = comparison().compareBoth(b, a, T.inverse(), kFineColumns);
  EXPECT_EQ(countsOf(both), Eigen::Vector3i(countsOf(there) + countsOf(back)));
  EXPECT_EQ(countsOf(swapped), countsOf(both));
  EXPECT_DOUBLE_EQ(swapped.likelihood, both.likelihood);
}

TEST(DepthConsistency, TwoViewsOfARoomAgreeAtTheTruePoseOnly) {
  const Eigen::Isometry3d A = lookingAlong({1, 0.5, 1.2}, {0.4, 1, -0.2}),
                          B = lookingAlong({1.5, 0.9, 1.3}, {0.2, 1, -0.1});
  const DepthPicture a = roomFrom(A), b = roomFrom(B);
  const auto at = [&](const Eigen::Vector3d& shift) {
    Eigen::Isometry3d T = B.inverse() * A;
    T.translation() += shift;
    return comparison().compareBoth(a, b, T, kFineColumns);
  };
  const DepthAgreement truth = at({0, 0, 0});
  EXPECT_LT(truth.contradict, 0.005 * truth.agree);
  for (const double metres : {0.3, -0.3})
    for (int axis = 0; axis < 3; ++axis) {
      const DepthAgreement moved = at(metres * Eigen::Vector3d::Unit(axis));
      EXPECT_GT(moved.contradict, truth.contradict);
      EXPECT_LT(moved.net(), truth.net());
      EXPECT_LT(moved.likelihood, truth.likelihood);
    }
}

TEST(DepthConsistency, LabelsAddUpToTheCountsOfCompare) {
  const Eigen::Isometry3d A = lookingAlong({1, 0.5, 1.2}, {0.4, 1, -0.2}),
                          B = lookingAlong({1.4, 0.8, 1.3}, {0.2, 1, -0.1});
  const DepthPicture a = roomFrom(A), b = roomFrom(B);
  Eigen::Isometry3d T = B.inverse() * A;
  T.translation() += Eigen::Vector3d(0.15, -0.05, 0.1);
  const DepthAgreement want = comparison().compare(a, b, T, kFineColumns);
  EXPECT_EQ(countsOf(comparison().count(a, b, T, kFineColumns)), countsOf(want));
  const DepthComparison compared = comparison();
  const DepthComparator judge(compared, a, b, T);
  DepthAgreement sum;
  const int step = gridStep(a, kFineColumns);
  for (int v = step / 2; v < a.camera.height; v += step)
    for (int u = step / 2; u < a.camera.width; u += step) switch (judge(u, v)) {
      case DepthLabel::agree:
        ++sum.agree;
        break;
      case DepthLabel::contradict:
        ++sum.contradict;
        break;
      case DepthLabel::occluded:
        ++sum.occluded;
        break;
      case DepthLabel::outside:
        break;
      }
  EXPECT_GT(want.contradict, 0);
  EXPECT_GT(want.occluded, 0);
  EXPECT_EQ(countsOf(sum), countsOf(want));
}

TEST(DepthConsistency, TheToleranceIsThreeTimesTheErrorOfAPrediction) {
  // METHOD 8.1: sigma_e = 1.5 DU + 0.01 d, gate 3 sigma_e.
  const double d = 0.5;
  const DepthErrors errors = comparison().errorsBetween(wallAt(2), wallAt(3));
  EXPECT_NEAR(errors.tolerance(d), 3 * (1.5 / kKinectGain + 0.01 * d), 1e-9);
  const double slack = errors.tolerance(1 / 2.0);
  const double inside = 1 / (0.5 - 0.9 * slack), outside = 1 / (0.5 - 1.1 * slack);
  EXPECT_EQ(comparison().compare(wallAt(2), wallAt(inside), kHere, kFineColumns).contradict, 0);
  EXPECT_EQ(comparison().compare(wallAt(2), wallAt(outside), kHere, kFineColumns).agree, 0);
}

TEST(DepthConsistency, TheErrorIsThatOfTheNoiseOfBothPictures) {
  DepthPicture noisier = wallAt(2);
  noisier.noise.inverse_depth_std = 3 * SensorNoise{}.inverse_depth_std;
  const DepthErrors errors = comparison().errorsBetween(wallAt(2), noisier);
  EXPECT_NEAR(errors.absolute, std::sqrt((1 + 9) / 2.0) * 1.5 / kKinectGain, 1e-9);
  EXPECT_EQ(errors.absolute, comparison().errorsBetween(noisier, wallAt(2)).absolute);
  EXPECT_EQ(errors.relative, 0.01);
  const double slack = errors.tolerance(1 / 2.0), inside = 1 / (0.5 - 0.9 * slack);
  EXPECT_GT(comparison().compare(wallAt(2), wallAt(inside), kHere, kFineColumns).contradict, 0);
  EXPECT_EQ(comparison().compare(noisier, wallAt(inside), kHere, kFineColumns).contradict, 0);
}

TEST(DepthConsistency, LikelihoodIsThatOfTheErrorOfThePrediction) {
  constexpr double kUnitError = 1.673;  // METHOD 8.2
  for (const double z : {0.7, 1.0, 1.6, 2.0, 3.3, 5.5}) {
    const DepthAgreement a = comparison().compare(wallAt(z), wallAt(z), kHere, kFineColumns);
    ASSERT_GT(a.agree, 0);
    const DepthErrors errors = comparison().errorsBetween(wallAt(z), wallAt(z));
    const double want = std::log(kUnitError * errors.absolute / errors.of(1 / z));
    EXPECT_NEAR(a.likelihood / a.agree, want, 2e-4) << z;  // the pictures are in quanta
  }
}

TEST(DepthConsistency, ExactAgreementIsLikelierThanContradictionWhateverTheErrors) {
  DepthPicture wall = wallAt(2);
  wall.noise.inverse_depth_std = 1 / kKinectGain;
  for (const double absolute : {0.01, 0.3, 3.0, 30.0})
    for (const double relative : {0.0, 0.003, 0.1}) {
      DepthCalibration params;
      params.absolute_error = absolute, params.relative_error = relative;
      const DepthAgreement a = DepthComparison(params).compare(wall, wall, kHere, kFineColumns);
      ASSERT_GT(a.agree, 0);
      EXPECT_GT(a.likelihood / a.agree, std::log(0.25)) << absolute << " " << relative;  // an occlusion
    }
}

TEST(DepthConsistency, UnknownFarAndOutsidePixelsAreNotCounted) {
  const auto total = [](const DepthAgreement& a) { return a.agree + a.contradict + a.occluded; };
  DepthImage blank = render({}, smallCamera()).image;
  EXPECT_EQ(total(comparison().compare(wallAt(2), DepthPicture::fromDepth(blank), kHere, kFineColumns)), 0);
  EXPECT_EQ(total(comparison().compare(DepthPicture::fromDepth(blank), wallAt(2), kHere, kFineColumns)), 0);
  EXPECT_EQ(total(comparison().compare({}, wallAt(2), kHere, kFineColumns)), 0);
  EXPECT_EQ(total(comparison().compare(wallAt(2), {}, kHere, kFineColumns)), 0);
  EXPECT_EQ(total(comparison().compare(wallAt(6.1), wallAt(6.1), kHere, kFineColumns)),
            0);  // beyond max_depth
  EXPECT_GT(total(comparison().compare(wallAt(5.9), wallAt(5.9), kHere, kFineColumns)), 0);
  Eigen::Isometry3d behind = kHere;
  behind.translation().z() = -5;
  EXPECT_EQ(total(comparison().compare(wallAt(2), wallAt(2), behind, kFineColumns)), 0);
  Eigen::Isometry3d turned = kHere;
  turned.linear() = expSO3({0, 2, 0});
  EXPECT_EQ(total(comparison().compare(wallAt(2), wallAt(2), turned, kFineColumns)), 0);
}

TEST(DepthConsistency, AnyPoseIsSafe) {
  test::Rng rng(1);
  const DepthPicture a = roomFrom(lookingAlong({1, 0.5, 1.2}, {0.4, 1, -0.2}));
  for (int i = 0; i < 300; ++i) {
    const DepthAgreement d =
        comparison().compareBoth(a, a, test::randomPose(rng, 3.1, i % 2 ? 1 : 1e6), kFineColumns);
    EXPECT_LE(d.agree + d.contradict + d.occluded, 2 * pixelsOfGrid(a, kFineColumns));
    EXPECT_TRUE(std::isfinite(d.likelihood));
  }
}

}  // namespace
}  // namespace facetloc
