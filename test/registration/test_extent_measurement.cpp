// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/plane_measurement.h"

#include <gtest/gtest.h>

namespace facetloc::internal {
namespace {

Segment board(const Eigen::Vector3d& t, double half_length, double half_width) {
  Segment s;
  s.R = Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  s.t = t;
  s.lambda = {half_length * half_length / 3, half_width * half_width / 3};
  return s;
}

TEST(ExtentMeasurement, JacobianIsTheDerivative) {
  const Segment scene = board({0.1, 0.2, 1.5}, 0.3, 0.1), model = board({-0.2, 0.1, 1.3}, 0.2, 0.1);
  Eigen::Isometry3d T(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY()));
  T.pretranslate(Eigen::Vector3d(0.3, -0.1, 0.2));
  const ExtentMeasurement m = measureExtent(scene, model, T);
  constexpr double kStep = 1e-6;
  for (int k = 0; k < 6; ++k) {
    const Vector6d d = kStep * Vector6d::Unit(k);
    const Eigen::Vector2d slope =
        (measureExtent(scene, model, boxplus(T, d)).h - measureExtent(scene, model, boxplus(T, -d)).h) /
        (2 * kStep);
    EXPECT_TRUE(slope.isApprox(m.H.col(k), 1e-6)) << k;
  }
}

// Two equal boards of half length a overlap up to 2 a apart: a uniform distance has the variance 4 a^2 / 3.
TEST(ExtentMeasurement, VarianceIsThatOfAllPositionsThatOverlap) {
  const Segment s = board({0, 0, 2}, 0.3, 0.1);
  const ExtentMeasurement m = measureExtent(s, s, Eigen::Isometry3d::Identity());
  EXPECT_NEAR(m.h.norm(), 0, 1e-12);
  EXPECT_NEAR(m.W(0, 0), 4 * 0.3 * 0.3 / 3, 1e-12);
  EXPECT_NEAR(m.W(1, 1), 4 * 0.1 * 0.1 / 3, 1e-12);
  EXPECT_NEAR(m.W(0, 1), 0, 1e-12);
}

TEST(ExtentMeasurement, ASegmentWithoutExtentSaysNothing) {
  const Segment s = board({0, 0, 2}, 0, 0);
  EXPECT_TRUE(informationOf(measureExtent(s, s, Eigen::Isometry3d::Identity())).isZero());
}

}  // namespace
}  // namespace facetloc::internal
