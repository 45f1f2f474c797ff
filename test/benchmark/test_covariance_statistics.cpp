// SPDX-License-Identifier: BSD-3-Clause
#include "covariance_statistics.h"

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace facetloc::benchmarks {
namespace {

using Axis = CovarianceStatistics::Axis;

constexpr int kPoses = 20000;

/** Correlated, with standard deviations of millimetres to decimetres and of about a degree. */
Matrix6d someCovariance() {
  Matrix6d root = Matrix6d::Zero();
  root.diagonal() << 0.02, 0.01, 0.005, 0.2, 0.03, 0.004;
  root(3, 1) = 0.05;
  root(4, 0) = -0.01;
  root(5, 3) = 0.002;
  return root * root.transpose();
}

Vector6d drawn(const Matrix6d& P, std::mt19937& random) {
  std::normal_distribution<double> normal;
  Vector6d white;
  for (double& x : white) x = normal(random);
  return P.llt().matrixL() * white;
}

Eigen::Isometry3d somePose() {
  return Eigen::Translation3d(3, -1, 2) * Eigen::AngleAxisd(2, Eigen::Vector3d(1, -2, 0.5).normalized());
}

/** Errors of this covariance, poses that state another one. */
CovarianceStatistics statisticsOf(const Matrix6d& errors, const Matrix6d& stated,
                                  const Matrix6d& truth = Matrix6d::Zero()) {
  std::mt19937 random(1);
  CovarianceStatistics all;
  for (int i = 0; i < kPoses; ++i) {
    const Eigen::Isometry3d T_true = boxplus(somePose(), drawn(truth + 1e-12 * Matrix6d::Identity(), random));
    all.add({boxplus(somePose(), -drawn(errors, random)), stated}, T_true, truth);
  }
  return all;
}

void expectRight(const CovarianceStatistics& s) {
  // Three standard deviations of 20000 samples, or more: sqrt(12 / n), sqrt(p q / n).
  EXPECT_NEAR(s.meanNees(), 6, 0.08);
  EXPECT_NEAR(s.nees(0.5), 5.35, 0.1);
  EXPECT_NEAR(s.nees(0.97), 13.97, 0.4);
  EXPECT_NEAR(s.inside50(), 0.5, 0.011);
  EXPECT_NEAR(s.inside95(), 0.95, 0.005);
  for (const Axis axis : {Axis::weakest, Axis::middle, Axis::strongest}) {
    EXPECT_NEAR(s.ratio(axis, 0.5), 0.674, 0.02) << axis;
    EXPECT_NEAR(s.ratio(axis, 0.9), 1.645, 0.04) << axis;
    EXPECT_NEAR(s.ratio(axis, 0.97), 2.170, 0.07) << axis;
  }
}

TEST(CovarianceStatistics, ErrorsOfTheStatedCovarianceGiveTheFiguresOfChiSquared) {
  expectRight(statisticsOf(someCovariance(), someCovariance()));
}

TEST(CovarianceStatistics, TheErrorOfTheTruthIsAdded) {
  const Matrix6d truth = covarianceOfTruth(2, 30);
  expectRight(statisticsOf(someCovariance(), someCovariance(), truth));
}

TEST(CovarianceStatistics, TheTruthsErrorHasTheGivenRootMeanSquares) {
  std::mt19937 random(2);
  double rotation = 0, translation = 0;
  for (int i = 0; i < kPoses; ++i) {
    const Vector6d d = drawn(covarianceOfTruth(2, 30), random);
    rotation += d.head<3>().squaredNorm() / kPoses;
    translation += d.tail<3>().squaredNorm() / kPoses;
  }
  EXPECT_NEAR(std::sqrt(rotation) / kDegree, 2, 0.03);
  EXPECT_NEAR(1e3 * std::sqrt(translation), 30, 0.4);
}

TEST(CovarianceStatistics, StatedTooSmallIsSeenAlongItsAxis) {
  Matrix6d stated = Matrix6d::Identity(), errors = stated;
  stated *= 1e-4;
  stated(4, 4) = 4e-4;  // the weakest axis of the position
  stated(5, 5) = 0.25e-4;
  errors = stated;
  errors(4, 4) *= 9;
  const CovarianceStatistics s = statisticsOf(errors, stated);
  EXPECT_NEAR(s.meanNees(), 5 + 9, 0.3);
  EXPECT_LT(s.inside95(), 0.75);
  EXPECT_NEAR(s.ratio(Axis::weakest, 0.5), 3 * 0.674, 0.06);
  EXPECT_NEAR(s.ratio(Axis::middle, 0.5), 0.674, 0.02);
  EXPECT_NEAR(s.ratio(Axis::strongest, 0.5), 0.674, 0.02);
}

TEST(CovarianceStatistics, LeavesOutInvalidCovariances) {
  CovarianceStatistics s;
  EXPECT_EQ(s.meanNees(), 0);
  EXPECT_EQ(s.inside95(), 0);
  Matrix6d indefinite = Matrix6d::Identity();
  indefinite(2, 2) = -1;
  s.add({somePose(), indefinite}, somePose(), Matrix6d::Zero());
  s.add({somePose(), Matrix6d::Constant(std::nan(""))}, somePose(), Matrix6d::Zero());
  s.add({somePose(), Matrix6d::Identity()}, somePose(), Matrix6d::Zero());
  EXPECT_EQ(s.size(), 1u);
  EXPECT_EQ(s.invalid(), 2u);
}

}  // namespace
}  // namespace facetloc::benchmarks
