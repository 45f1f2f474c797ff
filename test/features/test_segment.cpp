// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/segment.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/random_segments.h>

#include <gtest/gtest.h>

#include <cmath>

namespace facetloc {
namespace {

using test::MatrixNear, test::rectangleHull, test::Rng, test::uniform;

ConvexHull regularPolygon(int n, float radius) {
  ConvexHull hull;
  for (int i = 0; i < n; ++i) {
    const float angle = static_cast<float>(2 * EIGEN_PI * i / n);
    hull.vertex[hull.size++] = radius * Eigen::Vector2f(std::cos(angle), std::sin(angle));
  }
  return hull;
}

TEST(ConvexHull, AreaIsThatOfKnownShapes) {
  EXPECT_FLOAT_EQ(rectangleHull(1.5, 0.5).area(), 3.f);
  const int n = ConvexHull::kMaxVertices;
  EXPECT_NEAR(regularPolygon(n, 2).area(), 0.5 * n * 4 * std::sin(2 * EIGEN_PI / n), 1e-5);
  EXPECT_EQ(ConvexHull{}.area(), 0.f);
}

TEST(ConvexHull, AreaDoesNotDependOnThePlaceOfTheOrigin) {
  ConvexHull hull = regularPolygon(7, 0.5f);
  const float area = hull.area();
  for (int i = 0; i < hull.size; ++i) hull.vertex[i] += Eigen::Vector2f(3, -2);
  EXPECT_NEAR(hull.area(), area, 1e-5);
}

TEST(ConvexHull, ContainsPointsInsideOnly) {
  const ConvexHull hull = rectangleHull(1, 0.5);
  Rng rng(1);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector2f p = Eigen::Vector2d{uniform(rng, -2, 2), uniform(rng, -2, 2)}.cast<float>();
    EXPECT_EQ(hull.contains(p), std::abs(p.x()) <= 1 && std::abs(p.y()) <= 0.5) << p.transpose();
  }
}

TEST(ConvexHull, MarginGrowsTheOutlineByItsLength) {
  const ConvexHull hull = rectangleHull(1, 0.5);
  EXPECT_TRUE(hull.contains({1.09f, 0.f}, 0.1f));
  EXPECT_FALSE(hull.contains({1.11f, 0.f}, 0.1f));
  EXPECT_TRUE(hull.contains({0.f, -0.59f}, 0.1f));
  EXPECT_FALSE(hull.contains({0.f, -0.61f}, 0.1f));
  // Nothing within the margin is missed, also at the corners.
  for (float angle = 0; angle < 1.57f; angle += 0.1f)
    EXPECT_TRUE(hull.contains(
        Eigen::Vector2f(1, 0.5f) + 0.099f * Eigen::Vector2f(std::cos(angle), std::sin(angle)), 0.1f));
}

TEST(ConvexHull, AnEmptyOutlineContainsNothing) {
  ConvexHull hull;
  EXPECT_FALSE(hull.contains({0, 0}, 10.f));
  hull = rectangleHull(1, 1);
  hull.size = 2;
  EXPECT_FALSE(hull.contains({0, -1}, 10.f));
}

TEST(Segment, TransformedMovesEveryPointOfItsPlane) {
  Rng rng(2);
  for (int i = 0; i < 100; ++i) {
    const Segment s = test::randomSegment(rng);
    const Eigen::Isometry3d T = test::randomPose(rng, 3, 4);
    const Segment moved = transformed(s, T);
    const Eigen::Vector3d in_plane{uniform(rng, -1, 1), uniform(rng, -1, 1), 0};
    EXPECT_THAT((moved.R * in_plane + moved.t).eval(), MatrixNear(T * (s.R * in_plane + s.t), 1e-12));
    EXPECT_THAT(moved.normal(), MatrixNear(T.linear() * s.normal(), 1e-12));
    EXPECT_THAT(moved.Sigma_q, MatrixNear(s.Sigma_q, 0));  // q lives in S_F
    EXPECT_EQ(moved.num_points, s.num_points);
    EXPECT_EQ(moved.area(), s.area());
  }
}

}  // namespace
}  // namespace facetloc
