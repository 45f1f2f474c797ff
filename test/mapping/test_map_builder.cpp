// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/mapping/map_builder.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/random_segments.h>

#include <gtest/gtest.h>

namespace facetloc {
namespace {

using test::Rng;

Eigen::Isometry3d pose(double x, double turn_deg) {
  return Eigen::Translation3d(x, 0, 0) * Eigen::Isometry3d(expSO3({0, 0, turn_deg * kDegree}));
}

TEST(MapBuilder, TheFirstImageIsAlwaysALocalModel) { EXPECT_TRUE(MapBuilder().accept(pose(7, 30))); }

TEST(MapBuilder, HalfAMetreOrFifteenDegreesMakeALocalModel) {
  const auto accepts = [](double x, double turn) {
    MapBuilder builder;
    builder.accept(pose(0, 0));
    return builder.accept(pose(x, turn));
  };
  EXPECT_FALSE(accepts(0, 0));
  EXPECT_FALSE(accepts(0.499, 14.99));
  EXPECT_TRUE(accepts(0.5, 0));  // the limits themselves count
  EXPECT_TRUE(accepts(-0.5, 0));
  EXPECT_TRUE(accepts(0, 15));
  EXPECT_TRUE(accepts(0, -15));
  EXPECT_FALSE(accepts(0.4999, 0));
  EXPECT_FALSE(accepts(0, 14.999));
}

TEST(MapBuilder, TheLimitsHoldAnywhereInTheWorld) {
  Rng rng(1);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Isometry3d T = test::randomPose(rng, 3, 50);
    Eigen::Isometry3d moved = T, turned = T;
    moved.translation() += 0.5 * test::randomDirection(rng);
    turned.linear() = expSO3(15 * kDegree * test::randomDirection(rng)) * T.linear();
    for (const Eigen::Isometry3d& next : {moved, turned}) {
      MapBuilder builder;
      builder.accept(T);
      EXPECT_TRUE(builder.accept(next));
    }
  }
}

TEST(MapBuilder, MeasuresFromTheLatestLocalModelNotFromTheLatestImage) {
  MapBuilder builder;
  std::vector<double> models;
  for (int i = 0; i <= 200; ++i)
    if (builder.accept(pose(0.01 * i, 0))) models.push_back(0.01 * i);
  EXPECT_EQ(models.size(), 5u);
  for (std::size_t i = 0; i < models.size(); ++i) EXPECT_NEAR(models[i], 0.5 * static_cast<double>(i), 1e-9);
  EXPECT_TRUE(builder.accept(pose(0, 0)));  // coming back counts as well
}

TEST(MapBuilder, LimitsAreParameters) {
  MapBuilderParams params;
  params.distance = 2, params.rotation_deg = 90;
  MapBuilder builder(params);
  EXPECT_TRUE(builder.accept(pose(0, 0)));
  EXPECT_FALSE(builder.accept(pose(1.9, 89)));
  EXPECT_TRUE(builder.accept(pose(2, 0)));
}

TEST(MapBuilder, LinksHoldTheRelativePoseAndTheAccuracyOfThePoses) {
  Rng rng(2);
  const Eigen::Isometry3d a = test::randomPose(rng, 3, 5), b = test::randomPose(rng, 3, 5);
  const Link link = MapBuilder().link(3, 4, a, b);
  EXPECT_EQ(link.from, 3);
  EXPECT_EQ(link.to, 4);
  EXPECT_THAT(a * link.T_from_to.T, test::PoseNear(b, 1e-12, 1e-10));
  EXPECT_THAT(link.T_from_to.P, test::IsPositiveSemidefinite(1e-15));
}

TEST(MapBuilder, TheErrorOfALinkIsThatOfBothPoses) {
  Rng rng(5);
  const MapBuilderParams params;
  const Eigen::Isometry3d a = test::randomPose(rng, 3, 5), b = test::randomPose(rng, 3, 5);
  const Link link = MapBuilder(params).link(0, 1, a, b);
  const auto given = [&](const Eigen::Isometry3d& T) {  // as if measured
    Vector6d error = test::gaussian<6>(rng);
    error.head<3>() *= params.pose_rotation_std_deg * kDegree;
    error.tail<3>() *= params.pose_translation_std;
    return boxplus(T, error);
  };
  constexpr int kTrials = 20000;
  Matrix6d sampled = Matrix6d::Zero();
  for (int i = 0; i < kTrials; ++i) {
    const Vector6d e = boxminus(given(a).inverse() * given(b), link.T_from_to.T);
    sampled += e * e.transpose() / kTrials;
  }
  const Matrix6d inverse = link.T_from_to.P.inverse();
  EXPECT_THAT((inverse * sampled).eval(), test::MatrixNear(Matrix6d::Identity(), 0.4));
  EXPECT_NEAR((inverse * sampled).trace(), 6, 0.1);
  EXPECT_NEAR(sampled(2, 2), link.T_from_to.P(2, 2), 0.05 * link.T_from_to.P(2, 2));
  EXPECT_NEAR(sampled(3, 3), link.T_from_to.P(3, 3), 0.05 * link.T_from_to.P(3, 3));
  EXPECT_NEAR(sampled(5, 1), link.T_from_to.P(5, 1), 0.05 * link.T_from_to.P(5, 5));
}

}  // namespace
}  // namespace facetloc
