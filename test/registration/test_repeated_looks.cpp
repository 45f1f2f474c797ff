// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/registration/repeated_looks.h>
#include <facetloc/testing/random_segments.h>

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

namespace facetloc {
namespace {

const Eigen::Isometry3d kStill = Eigen::Isometry3d::Identity();

Surroundings twoModels() {
  test::Rng rng(3);
  const auto viewOfTwo = [&rng] {
    auto view = std::make_shared<View>();
    view->segments = {test::randomSegment(rng), test::randomSegment(rng)};
    return view;
  };
  Surroundings surroundings;
  surroundings.add(4, viewOfTwo(), kStill);
  surroundings.add(9, viewOfTwo(), kStill);
  return surroundings;
}

/** How many times as large the covariance of a segment is. */
double factor(const RepeatedLooks& looks, int segment) {
  const Surroundings before = twoModels();
  Surroundings after = before;
  looks.discount(after);
  return after.segments[segment].Sigma_q(0, 0) / before.segments[segment].Sigma_q(0, 0);
}

TEST(RepeatedLooks, TheFirstOneCountsInFull) {
  RepeatedLooks looks;
  looks.add({{0, 2, 0}}, twoModels());  // the first segment of the second model
  for (const int other : {0, 1, 3}) EXPECT_EQ(factor(looks, other), 1);
  EXPECT_GT(factor(looks, 2), 1);
}

TEST(RepeatedLooks, TellAllTogetherWhatOneMapAndManyViewsDo) {
  // A number is measured n times as the sum of an error of the map, always the same, and one of the view, of
  // variance 1 each: the mean of the measurements has the variance 1 + 1 / n.
  RepeatedLooks looks;
  double information = 0;
  for (int n = 1; n <= 30; ++n) {
    information += 1 / (1 + factor(looks, 0));
    EXPECT_NEAR(1 / information, 1 + 1.0 / n, 1e-9) << n;
    looks.add({{0, 0, 0}}, twoModels());
  }
}

TEST(RepeatedLooks, AreNewAgainElsewhere) {
  for (const bool turns : {false, true}) {
    RepeatedLooks looks;
    looks.add({{0, 0, 0}}, twoModels());
    const double there = factor(looks, 0);
    Eigen::Isometry3d step = kStill;
    if (turns)
      step.linear() = expSO3({0, 0, RepeatedLooks::kRotation});
    else
      step.translation().x() = RepeatedLooks::kDistance;
    looks.move(kStill);
    EXPECT_EQ(factor(looks, 0), there);
    looks.move(step);
    const double n = 1 + std::exp(-1.0);  // looks that are left, and the next one
    EXPECT_NEAR(factor(looks, 0), n * (n + 1) - 1, 1e-9);
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
