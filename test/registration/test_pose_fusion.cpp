// SPDX-License-Identifier: BSD-3-Clause
#include "shared/pose_fusion.h"

#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/random_segments.h>

#include <gtest/gtest.h>

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
    b.T = perturbed(a.T, offset);
    const PoseWithCovariance both = fused(a, b);
    const Matrix6d information = a.P.inverse() + b.P.inverse();
    EXPECT_THAT(both.P * information, test::MatrixNear(Matrix6d::Identity(), 1e-8));
    const Vector6d expected = information.inverse() * b.P.inverse() * offset;
    EXPECT_LT((perturbation(a.T, both.T) - expected).norm(), 1e-6 * offset.norm() + 1e-8);
  }
}

TEST(PoseFusion, APartOfWhatWasAddedIsAPartOfItsInformation) {
  test::Rng rng(4);
  const Matrix6d prior = randomCovariance(rng, 1e-2);
  const Matrix6d measured = randomCovariance(rng, 1e-3);
  const Matrix6d posterior = (prior.inverse() + measured.inverse()).inverse();
  EXPECT_THAT(discounted(prior, posterior, 0), test::MatrixNear(prior, 1e-9));
  EXPECT_THAT(discounted(prior, posterior, 1), test::MatrixNear(posterior, 1e-9));
  // A measurement that errs so that it tells a quarter has four times the covariance.
  const Matrix6d quarter = (prior.inverse() + (4 * measured).inverse()).inverse();
  EXPECT_THAT(discounted(prior, posterior, 0.25), test::MatrixNear(quarter, 1e-9));
}

}  // namespace
}  // namespace facetloc
