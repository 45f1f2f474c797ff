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
double factor(const RepeatedLooks& looks, int segment) {
  const LocalMap before = twoModels();
  LocalMap after = before;
  looks.discount(after);
  return after.segments[segment].Sigma_q(0, 0) / before.segments[segment].Sigma_q(0, 0);
}

TEST(RepeatedLooks, TheFirstOneCountsInFull) {
  RepeatedLooks looks;
  looks.add({{0, 2, 0}}, twoModels());  // the first segment of the second model
  for (const int other : {0, 1, 3}) EXPECT_EQ(factor(looks, other), 1);
  EXPECT_GT(factor(looks, 2), 1);
}

TEST(RepeatedLooks, HaveTheInformationOfCorrelatedMeasurements) {
  // The mean of n measurements whose errors have the correlation rho^|i - k|, by their whole covariance.
  for (const double distance : {0.01, 0.1, 0.4}) {
    RepeatedLooks looks;
    looks.add({{0, 0, 0}}, twoModels());
    looks.move(Eigen::Isometry3d(Eigen::Translation3d(0, distance, 0)));
    const double rho = std::exp(-distance / RepeatedLooks::kDistance);
    const auto information = [rho](int n) {
      Eigen::MatrixXd C(n, n);
      for (int i = 0; i < n; ++i)
        for (int k = 0; k < n; ++k) C(i, k) = std::pow(rho, std::abs(i - k));
      return C.llt().solve(Eigen::VectorXd::Ones(n)).sum();
    };
    EXPECT_NEAR(1 / factor(looks, 0), information(11) - information(10), 1e-9) << distance;
  }
}

TEST(RepeatedLooks, AddNoInformationWhileTheCameraStands) {
  RepeatedLooks looks;
  looks.add({{0, 0, 0}}, twoModels());
  looks.move(kStill);
  EXPECT_GT(factor(looks, 0), 1e4);
  EXPECT_TRUE(std::isfinite(factor(looks, 0)));
}

TEST(RepeatedLooks, AreNewAgainElsewhere) {
  for (const bool turns : {false, true}) {
    RepeatedLooks looks;
    looks.add({{0, 0, 0}}, twoModels());
    Eigen::Isometry3d step = kStill;
    if (turns)
      step.linear() = expSO3({0, 0, RepeatedLooks::kRotation});
    else
      step.translation().x() = RepeatedLooks::kDistance;
    looks.move(step);
    const double rho = std::exp(-1.0);
    EXPECT_NEAR(factor(looks, 0), (1 + rho) / (1 - rho), 1e-9);
    for (int i = 0; i < 5; ++i) looks.move(step);
    EXPECT_EQ(factor(looks, 0), 1);
  }
}

TEST(RepeatedLooks, CanBeForgotten) {
  RepeatedLooks looks;
  looks.add({{0, 0, 0}}, twoModels());
  looks.clear();
  EXPECT_EQ(factor(looks, 0), 1);
}

}  // namespace
}  // namespace facetloc
