// SPDX-License-Identifier: BSD-3-Clause
#include "belief/place_following.h"

#include <facetloc/testing/random_segments.h>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

namespace facetloc {

using namespace internal;
namespace {

const Eigen::Isometry3d kStill = Eigen::Isometry3d::Identity();

LocalMap twoModels() {
  test::Rng rng(3);
  const auto viewOfTwo = [&rng] {
    auto view = std::make_shared<View>();
    view->segments = {test::randomSegment(rng), test::randomSegment(rng)};
    return view;
  };
  LocalMap surroundings;
  surroundings.add(4, viewOfTwo(), kStill);
  surroundings.add(9, viewOfTwo(), kStill);
  return surroundings;
}

/** How many times as large the covariance of a segment is. */
double factor(const RepeatedObservations& observations, int segment) {
  const LocalMap before = twoModels();
  LocalMap after = before;
  observations.discount(after);
  return after.segments[segment].Sigma_q(0, 0) / before.segments[segment].Sigma_q(0, 0);
}

TEST(RepeatedObservations, TheFirstOneCountsInFull) {
  RepeatedObservations observations;
  observations.add({{0, 2, 0}}, twoModels());  // the first segment of the second model
  for (const int other : {0, 1, 3}) EXPECT_EQ(factor(observations, other), 1);
  EXPECT_GT(factor(observations, 2), 1);
}

TEST(RepeatedObservations, HaveTheInformationOfCorrelatedMeasurements) {
  // The mean of n measurements whose errors have the correlation rho^|i - k|, by their whole covariance.
  for (const double way : {0.01, 0.1, 0.4}) {
    RepeatedObservations observations;
    observations.add({{0, 0, 0}}, twoModels());
    observations.move(Eigen::Isometry3d(Eigen::Translation3d(0, way, 0)));
    const double rho = std::exp(-way / RepeatedObservations::kDistance);
    const auto information = [rho](int n) {
      Eigen::MatrixXd C(n, n);
      for (int i = 0; i < n; ++i)
        for (int k = 0; k < n; ++k) C(i, k) = std::pow(rho, std::abs(i - k));
      return C.llt().solve(Eigen::VectorXd::Ones(n)).sum();
    };
    EXPECT_NEAR(1 / factor(observations, 0), information(11) - information(10), 1e-9) << way;
  }
}

TEST(RepeatedObservations, AddNoInformationWhileTheCameraStands) {
  RepeatedObservations observations;
  observations.add({{0, 0, 0}}, twoModels());
  observations.move(kStill);
  EXPECT_GT(factor(observations, 0), 1e4);
  EXPECT_TRUE(std::isfinite(factor(observations, 0)));
}

TEST(RepeatedObservations, AreNewAgainElsewhere) {
  for (const bool turns : {false, true}) {
    RepeatedObservations observations;
    observations.add({{0, 0, 0}}, twoModels());
    Eigen::Isometry3d step = kStill;
    if (turns)
      step.linear() = expSO3({0, 0, RepeatedObservations::kRotation});
    else
      step.translation().x() = RepeatedObservations::kDistance;
    observations.move(step);
    const double rho = std::exp(-1.0);
    EXPECT_NEAR(factor(observations, 0), (1 + rho) / (1 - rho), 1e-9);
    for (int i = 0; i < 5; ++i) observations.move(step);
    EXPECT_EQ(factor(observations, 0), 1);
  }
}

TEST(RepeatedObservations, CanBeForgotten) {
  RepeatedObservations observations;
  observations.add({{0, 0, 0}}, twoModels());
  observations.clear();
  EXPECT_EQ(factor(observations, 0), 1);
}

}  // namespace
}  // namespace facetloc
