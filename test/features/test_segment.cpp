// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/local_model.h>
#include <facetloc/features/segment.h>
#include <facetloc/testing/map_of_view.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/random_segments.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

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

View viewOf(int segments, bool picture = true) {
  View view;
  view.segments.resize(static_cast<std::size_t>(segments));
  if (picture) view.depth.camera = {160, 120, 130, 130, 80, 60};
  return view;
}

/** View number i has i segments; the odd ones have a picture. */
struct Counting : MapStore {
  std::shared_ptr<const View> view(int i) const override {
    return std::make_shared<const View>(viewOf(i, i % 2 == 1));
  }
};

TEST(Map, HoldsTheViewsOfItsModels) {
  Map map;
  map.models.emplace_back("a", 1, std::nullopt, viewOf(3));
  map.models.emplace_back("b", 2);
  map.models[1].setView(viewOf(5, false));
  EXPECT_EQ(map.view(0)->segments.size(), 3u);
  EXPECT_EQ(map.view(1)->segments.size(), 5u);
  EXPECT_TRUE(map.models[0].hasPicture());
  EXPECT_FALSE(map.models[1].hasPicture());
  EXPECT_EQ(map.store(), nullptr);
}

TEST(Map, SharesItsViewsWithCopies) {
  const Map map = test::mapOf(viewOf(3));
  Map copy = map;
  EXPECT_EQ(copy.view(0), map.view(0));
  copy.models[0].setView(viewOf(4));
  EXPECT_EQ(map.view(0)->segments.size(), 3u);
  EXPECT_EQ(copy.view(0)->segments.size(), 4u);
}

TEST(Map, RefusesToReadAViewThatIsNotThere) {
  Map map;
  map.models.emplace_back("a", 1);
  EXPECT_FALSE(map.models[0].hasPicture());
  EXPECT_THROW(map.view(0), std::logic_error);
}

TEST(Map, FindsTheViewsOfAStoreInAnyOrderAndInOtherMaps) {
  Map stored;
  stored.models.resize(4);
  stored.setStore(std::make_shared<Counting>());
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(stored.view(i)->segments.size(), static_cast<std::size_t>(i));
    EXPECT_EQ(stored.models[static_cast<std::size_t>(i)].hasPicture(), i % 2 == 1);
  }
  std::reverse(stored.models.begin(), stored.models.end());
  EXPECT_EQ(stored.view(0)->segments.size(), 3u);
  Map other = test::mapOf(viewOf(7));
  other.models.push_back(stored.models[1]);
  EXPECT_EQ(other.view(1)->segments.size(), 2u);
  stored.models[0].setView(viewOf(9));
  EXPECT_EQ(stored.view(0)->segments.size(), 9u);
  EXPECT_EQ(stored.view(1)->segments.size(), 2u);
}

}  // namespace
}  // namespace facetloc
