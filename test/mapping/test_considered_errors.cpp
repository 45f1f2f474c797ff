// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/considered_errors.h"

#include <facetloc/testing/synthetic_views.h>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

namespace facetloc::internal {
namespace {

Vector6d normal(std::mt19937& random) {
  std::normal_distribution<double> unit;
  Vector6d x;
  for (int k = 0; k < 6; ++k) x[k] = unit(random);
  return x;
}

Vector6d diagonal(double rotation, double translation) {
  Vector6d d;
  d << Eigen::Vector3d::Constant(rotation), Eigen::Vector3d::Constant(translation);
  return d;
}

constexpr double kPixelTranslation = 5e-4;  // error by independent pixels [m]

/** Views of a camera with these errors, as a realignment finds them. */
std::vector<RealignedView> viewsWith(const ConsideredErrors& errors, int n) {
  std::mt19937 random(7);
  std::vector<RealignedView> views(n);
  for (RealignedView& view : views) {
    const Vector6d std = diagonal(2e-4, kPixelTranslation);
    Matrix6d factor = std.asDiagonal();
    factor.col(0) += std.cwiseProduct(0.5 * normal(random));
    const Matrix6d of_pixels = factor * factor.transpose();
    view.information = of_pixels.inverse();
    view.error =
        std::sqrt(errors.pixels_as_one) * factor * normal(random) +
        std::sqrt(2) * diagonal(errors.rotation_std, errors.translation_std).cwiseProduct(normal(random));
  }
  return views;
}

// Student's distribution takes a normal one for a little wider than it is, never for narrower.
TEST(ConsideredErrors, AreFoundFromTheErrorsOfViews) {
  for (const ConsideredErrors truth :
       {ConsideredErrors{4, 0.5 * kDegree, 0.02}, ConsideredErrors{400, 0.3 * kDegree, 0.02}}) {
    const ConsideredErrors found = consideredErrors(viewsWith(truth, 200));
    EXPECT_EQ(found.views, 200);
    EXPECT_NEAR(found.rotation_std / truth.rotation_std, 1.2, 0.25);
    EXPECT_NEAR(found.translation_std / truth.translation_std, 1.2, 0.25);
  }
  const ConsideredErrors by_pixels = consideredErrors(viewsWith({400, 1e-6, 1e-6}, 200));
  EXPECT_NEAR(std::sqrt(by_pixels.pixels_as_one / 400), 1.2, 0.25);
  EXPECT_LT(by_pixels.rotation_std, 0.03 * kDegree);
  EXPECT_LT(by_pixels.translation_std, 0.3 * std::sqrt(400) * kPixelTranslation);
}

TEST(ConsideredErrors, OfFewViewsAreDrawnTowardsTheUsual) {
  EXPECT_EQ(consideredErrors({}).pixels_as_one, ConsideredErrors().pixels_as_one);
  const ConsideredErrors truth{1, 0.01 * kDegree, 1e-4};
  const double many = consideredErrors(viewsWith(truth, 100)).translation_std;
  const double few = consideredErrors(viewsWith(truth, 3)).translation_std;
  EXPECT_LT(many, few);
  EXPECT_LT(few, ConsideredErrors().translation_std);
}

/** Local models of a room, whose poses err by these standard deviations. */
std::shared_ptr<const Map> roomWithPoseErrors(double rotation, double translation) {
  std::mt19937 random(3);
  auto map = std::make_shared<Map>();
  for (int i = 0; i < 24; ++i) {
    const Eigen::Isometry3d T_w_c = test::onCircle(15 * i, 1);
    const Eigen::Isometry3d erring =
        boxplus(T_w_c, diagonal(rotation, translation).cwiseProduct(normal(random)));
    map->models.emplace_back("view" + std::to_string(i), i, erring,
                             test::viewFrom(test::largeRoom(), T_w_c, static_cast<unsigned>(i)));
  }
  return map;
}

TEST(ConsideredErrors, OfAMapAreThoseOfItsPoses) {
  const ConsideredErrors exact = consideredErrors(realignedViews(roomWithPoseErrors(0, 0), 2));
  EXPECT_EQ(exact.views, 24);
  EXPECT_LT(exact.rotation_std, 0.1 * kDegree);
  EXPECT_LT(exact.translation_std, 0.004);
  const ConsideredErrors erring =
      consideredErrors(realignedViews(roomWithPoseErrors(0.5 * kDegree, 0.02), 2));
  EXPECT_NEAR(erring.rotation_std, 0.5 * kDegree, 0.25 * kDegree);
  EXPECT_NEAR(erring.translation_std, 0.02, 0.01);
}

TEST(ConsideredErrors, AreTheSameForAnyNumberOfThreads) {
  const auto map = roomWithPoseErrors(0.2 * kDegree, 0.01);
  EXPECT_EQ(toText(consideredErrors(realignedViews(map, 1))),
            toText(consideredErrors(realignedViews(map, 3))));
}

}  // namespace
}  // namespace facetloc::internal
