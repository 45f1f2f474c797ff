// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/cholesky3.h"

#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/random_segments.h>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace facetloc {
namespace {

using namespace internal;
using test::gaussian, test::MatrixNear, test::Rng;

TEST(Cholesky3, AgreesWithTheInverse) {
  Rng rng(1);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Matrix3d S = test::randomCovariance<3>(rng, {0.01, 0.5, 3}), inverse = S.inverse();
    Cholesky3 cholesky;
    ASSERT_TRUE(cholesky.compute(S));
    const Eigen::Vector3d v = gaussian<3>(rng);
    Eigen::Matrix<double, 3, 6> M;
    for (int k = 0; k < 6; ++k) M.col(k) = gaussian<3>(rng);
    const double scale = inverse.norm();
    EXPECT_THAT(cholesky.solve(v), MatrixNear(inverse * v, 1e-11 * scale));
    EXPECT_THAT(cholesky.solve<6>(M), MatrixNear(inverse * M, 1e-11 * scale));
    EXPECT_NEAR(cholesky.whiten(v).squaredNorm(), v.dot(inverse * v), 1e-11 * scale);
    EXPECT_NEAR(cholesky.squaredMahalanobis(v), v.dot(inverse * v), 1e-11 * scale);
    EXPECT_NEAR(cholesky.logDeterminant(), std::log(S.determinant()), 1e-10);
  }
}

TEST(Cholesky3, RefusesMatricesThatAreNotPositiveDefinite) {
  Cholesky3 cholesky;
  EXPECT_FALSE(cholesky.compute(Eigen::Matrix3d::Zero()));
  EXPECT_FALSE(cholesky.compute(-Eigen::Matrix3d::Identity()));
  EXPECT_FALSE(cholesky.compute(Eigen::Matrix3d::Ones()));  // rank one
  EXPECT_FALSE(cholesky.compute(Eigen::Matrix3d::Constant(std::numeric_limits<double>::quiet_NaN())));
  for (int i = 0; i < 3; ++i) {
    Eigen::Matrix3d S = Eigen::Matrix3d::Identity();
    S(i, i) = -1e-9;
    EXPECT_FALSE(cholesky.compute(S)) << i;
    S(i, i) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(cholesky.compute(S)) << i;
  }
}

}  // namespace
}  // namespace facetloc
