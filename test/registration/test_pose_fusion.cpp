// SPDX-License-Identifier: BSD-3-Clause
#include "poses/pose_fusion.h"

#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/random_segments.h>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <algorithm>

namespace facetloc {

using namespace internal;
namespace {

Matrix6d randomCovariance(test::Rng& rng, double scale) {
  Matrix6d A = Matrix6d::Zero();
  for (int i = 0; i < 6; ++i) A.col(i) = test::gaussian<6>(rng, Matrix6d::Identity());
  return scale * (A * A.transpose() + Matrix6d::Identity());
}

TEST(PoseFusion, TwoSourcesAreWeighedByTheirInformation) {
  test::Rng rng(3);
  for (int i = 0; i < 20; ++i) {
    PoseWithCovariance a, b;
    a.P = randomCovariance(rng, 1e-8);  // so close that rotations add
    b.P = randomCovariance(rng, 1e-8);
    const Vector6d offset = 1e-4 * test::gaussian<6>(rng, Matrix6d::Identity());
    b.T = boxplus(a.T, offset);
    const PoseWithCovariance both = fused(a, b);
    const Matrix6d information = a.P.inverse() + b.P.inverse();
    EXPECT_THAT(both.P * information, test::MatrixNear(Matrix6d::Identity(), 1e-8));
    const Vector6d expected = information.inverse() * b.P.inverse() * offset;
    EXPECT_LT((boxminus(both.T, a.T) - expected).norm(), 1e-6 * offset.norm() + 1e-8);
  }
}

TEST(PoseFusion, CommonInformationOfTwoSourcesIsNotCountedTwice) {
  test::Rng rng(5);
  const auto isAtLeast = [](const Matrix6d& P, const Matrix6d& least) {
    return Eigen::SelfAdjointEigenSolver<Matrix6d>(P - least).eigenvalues().minCoeff() >= -1e-15;
  };
  for (int i = 0; i < 20; ++i) {
    const Matrix6d common = randomCovariance(rng, 1e-8);
    const Matrix6d of_a = randomCovariance(rng, 1e-8), of_b = randomCovariance(rng, 1e-8);
    PoseWithCovariance a, b;
    a.P = common + of_a, b.P = common + of_b;
    b.T = boxplus(a.T, 1e-4 * test::gaussian<6>(rng, Matrix6d::Identity()));
    const PoseWithCovariance both = covarianceIntersection(a, b);
    // The true error of the estimate W a + (1 - W) b.
    const Vector6d offset = boxminus(b.T, a.T);
    Matrix6d W;
    for (int k = 0; k < 6; ++k) {
      PoseWithCovariance moved = b;
      moved.T = boxplus(a.T, 1e-4 * Vector6d::Unit(k));
      W.col(k) = 1e4 * boxminus(covarianceIntersection(a, moved).T, a.T);
    }
    const Matrix6d rest = Matrix6d::Identity() - W;
    EXPECT_TRUE(isAtLeast(both.P, common + rest * of_a * rest.transpose() + W * of_b * W.transpose()));
    EXPECT_LT((boxminus(both.T, a.T) - W * offset).norm(), 1e-3 * offset.norm());
    EXPECT_LE(both.P.determinant(), 1.0001 * std::min(a.P.determinant(), b.P.determinant()));
  }
  PoseWithCovariance a{Eigen::Isometry3d::Identity(), randomCovariance(rng, 1e-4)};
  EXPECT_THAT(covarianceIntersection(a, a).P, test::MatrixNear(a.P, 1e-12))
      << "the same once more tells nothing";
}

TEST(PoseFusion, APartOfAnUpdateHasAPartOfItsInformation) {
  test::Rng rng(4);
  const Matrix6d prior = randomCovariance(rng, 1e-2), measured = randomCovariance(rng, 1e-3);
  const Matrix6d posterior = (prior.inverse() + measured.inverse()).inverse();
  EXPECT_THAT(temper(prior, posterior, 0), test::MatrixNear(prior, 1e-9));
  EXPECT_THAT(temper(prior, posterior, 1), test::MatrixNear(posterior, 1e-9));
  // A measurement that errs so that it tells a quarter has four times the covariance.
  const Matrix6d quarter = (prior.inverse() + (4 * measured).inverse()).inverse();
  EXPECT_THAT(temper(prior, posterior, 0.25), test::MatrixNear(quarter, 1e-9));
}

}  // namespace
}  // namespace facetloc
